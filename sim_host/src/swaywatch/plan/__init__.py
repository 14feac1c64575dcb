"""Plan a test before it is driven: what it will tell, how long it takes, how far from danger.

``knowledge`` what is believed of a vehicle, ``information`` what a manoeuvre tells of it,
``design`` which manoeuvres to drive, ``files`` scenario and steering robot, ``page`` the report.
"""
