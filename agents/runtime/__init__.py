"""A robot's shell: asyncio and Zenoh.

tick_source           the next tick to answer.
beacon_subscriptions  subscriptions to the beacons of peers.
outbox                publishes, and keeps two ticks for retransmission.
marshalling           between messages and arrays.
membership            joins a run, and keeps its lease.
world_liveliness      liveliness of the world.
"""
