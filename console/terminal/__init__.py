"""Text and terminals.

formatting  numbers as text
counting    completed work, as a function that the work calls
printing    lines and tables, in which data is never markup
progress    bars of commands that take longer than a second
screen      full-screen frames: the only user of rich's Live
keyboard    keys pressed
"""
