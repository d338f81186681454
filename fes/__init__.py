"""The base that world, agents and observers share.

arrays     arrays, edges, geometry, keyed random draws
model      settings, sensing, contacts, the objective and the outage formula
extension  the public interface for laws, channels, bodies and metrics of others
protocol   key expressions, messages and their encoding
transport  a Zenoh session, and the way of its samples to asyncio
recording  the log of a run: format, writer and reader
system     files, signals, output and memory of the machine
process    exit codes, and Zenoh's command-line flags
errors     every error, on one page
"""
