"""The commands of ``swaywatch``: each module has ``add_parser(subparsers)`` and ``run(args)``."""
