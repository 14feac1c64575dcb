# readme-tables: the figures of the last `make bench` into README.md.
.PHONY: readme-tables
readme-tables:
	@tests/tools/readme-tables
