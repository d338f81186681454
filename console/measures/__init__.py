"""Numbers of a report that every view shows: arrays in, arrays out, without a terminal or a page.

belief     measures of real robots, whose truth is unknown
links      errors and losses of the links
reception  curves of reception as measuring robots learn it, and as it is
team       the plotted measures, the robots that are drawn, and the parts of the links
"""
