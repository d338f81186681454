"""The pages of the documentation, and the scripts that generate some of them.

generate     `python -m docs.generate` writes the generated pages of `docs/reference`
generators   one module per generated page
draw_layers  `python -m docs.draw_layers` draws the layers of imports as `docs/layers.svg`
"""
