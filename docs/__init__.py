"""The pages of the documentation, and the scripts that generate some of them.

generate     `python -m docs.generate` writes the generated pages of `docs/reference`
generators   one module per generated page
"""
