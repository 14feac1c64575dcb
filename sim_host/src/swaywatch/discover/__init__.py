"""Physics that no effect of the library is: where a force is missing, on what it depends, its law.

`grammar.py` has the laws that are tried, `find.py` chooses among them and the library by evidence
and by the run left out, `inputs.py` estimates the missing force itself, `sentences.py` says it.
"""
