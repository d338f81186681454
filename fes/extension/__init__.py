"""The public interface for laws, rules, channels, bodies and metrics of others: the one stable Python API.

protocols     what an extension implements, one protocol per kind.
neighborhood  what a robot's laws know of its peers at one tick.
context       what a constructor gets beside its parameters.
registry      extensions by name: built-in, installed, or from a module that this process was told to use.
"""

API = 1
"""Version of this interface."""
