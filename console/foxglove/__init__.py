"""A running run in Foxglove and Lichtblick, over a WebSocket; layout.json is a layout for both.

server    the WebSocket server, from a Report to its clients
messages  the topics of a log whose messages follow from a Report
"""
