"""A router separate from the world, as the source of a small program: a stand-in for zenohd, with the same code.

The program takes an endpoint to listen on, and those of routers to connect to. It prints "ready", and ends
when its standard input is closed.
"""

SOURCE = """
import asyncio, sys
from fes.transport import bus
from fes.transport.endpoints import Endpoints

async def main(listen, *connect):
    async with bus.opened(Endpoints("router", connect, (listen,))):
        print("ready", flush=True)
        await asyncio.to_thread(sys.stdin.read)

asyncio.run(main(*sys.argv[1:]))
"""
