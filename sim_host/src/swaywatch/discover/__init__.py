"""Physics outside the library: where a force is missing, on what it depends, and by which law.

`grammar.py` lists the laws that are tried, `find.py` selects among them and the library by evidence
and by prediction of the left-out run, `inputs.py` estimates the missing force itself, and
`sentences.py` words the result.
"""
