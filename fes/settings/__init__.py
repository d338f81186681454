"""Files of settings that a person writes, and errors in them in one line.

toml        TOML with bounds on depth and size
schema      the fields of a file: type, range, default, unit and description; its JSON schema
validation  the first rule of a table that is broken
"""
