# `make package`: wheel and source distribution, installed in a clean environment outside the
# repository, where a recording is analysed. Needs the package index.
.PHONY: package
package: setup
	@tests/tools/package $(B)/package
