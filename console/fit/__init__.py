"""fes fit: a channel from measurements.

command       the command, from its arguments to its lines
measurements  the file: packets, or received power
likelihood    the maximum of a likelihood with two parameters, by Newton's method
estimate      a channel with its confidence intervals
shares        shares of decoded packets by separation
report        the channel as TOML and as JSON
picture       the measurements and the channel as a figure
"""
