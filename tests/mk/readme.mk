# readme-tables: the figures of the last `make bench` into README.md and sim_host/docs/benchmarks.md.
.PHONY: readme-tables
readme-tables:
	@tests/tools/readme-tables

# readme-picture: the picture at the top of README.md, from a simulated drive and a diagnosis.
.PHONY: readme-picture
readme-picture: setup-test
	$(VENV)/bin/python tests/tools/readme_picture.py sim_host/docs/picture.svg
