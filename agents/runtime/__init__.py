"""A robot's shell: asyncio and Zenoh.

tick_source           the ticks at which an agent steps.
hosted_crew           the crew of the process: from messages to the payloads that answer a tick.
beacon_subscriptions  subscriptions to the beacons of peers.
outbox                publishes beacons and commands, and keeps two ticks for retransmission.
crew_run              a crew during a run, moved by the compiled core or by numpy.
marshalling           conversion between messages and arrays.
reception             applies the verdict of the radio: a crew gets only beacons that decoded.
membership            joins a run, and confirms later that the robots are still assigned.
model_freedom         whether this process can know the channel.
world_liveliness      liveliness of the world.
"""
