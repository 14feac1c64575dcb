"""Over night: a folder of recordings, in the morning which disagree with the model, where, why.

``plan`` finds the runs and what belongs to them, ``work`` analyses and diagnoses each in a process
of its own, ``page`` shows all of them on one page.
"""
