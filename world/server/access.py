"""Who may say and hear what: Zenoh's access control, from the table of keys.

It acts where messages enter and leave the world's router, by the common name of each link's certificate, and denies
what it does not name. What the world itself publishes passes no link, and no rule; where the router is another
process, the world is one more role, which may do all.

| role        | may say                       | may hear                                     | may ask              |
|-------------|-------------------------------|----------------------------------------------|----------------------|
| robot-<ids> | own beacons, commands, tokens | own observations, beacons, the world's token | welcome, lost beacon |
| observer    | nothing                       | reports, all tokens                          | who the world is     |
| operator    | nothing                       | reports, all tokens                          | that, a change       |
"""

from collections.abc import Iterable, Sequence
from typing import Any

from fes.protocol import keys
from fes.transport.identity import OBSERVER, OPERATOR, WORLD, robot_role

Rule = dict[str, object]


def control(run: str, robots: int, crews: Iterable[Sequence[int]] = (), *, world: bool = False) -> dict[str, object]:
    """The access control of a run of so many robots, each an agent of its own or hosted by one of `crews`.

    With `world` it is for a router that is not the world: the world comes over a link too, as do further routers,
    which show the world's certificate.
    """
    who: dict[str, Sequence[int]] = {robot_role([robot]): range(robot, robot + 1) for robot in range(robots)}
    who |= {robot_role(crew): crew for crew in crews if crew[-1] < robots}
    told = _all_are_told(run)
    rules = {role: [*_robot(run, role, hosted), *told] for role, hosted in who.items()}
    rules[OBSERVER] = [*_observer(run), *told]
    rules[OPERATOR] = [*rules[OBSERVER], *_operator(run)]
    if world:
        rules[WORLD] = [_everything(run)]
    every = {str(rule["id"]): rule for mine in rules.values() for rule in mine}
    settings = {
        "enabled": True,
        "default_permission": "deny",
        "rules": list(every.values()),
        "subjects": [{"id": role, "cert_common_names": [role]} for role in rules],
        "policies": [{"subjects": [role], "rules": [rule["id"] for rule in mine]} for role, mine in rules.items()],
    }
    return {"access_control": settings}


def roles(settings: dict[str, object]) -> list[str]:
    """Whom such settings name."""
    found: Any = settings["access_control"]
    return [subject["id"] for subject in found["subjects"]]


def _robot(run: str, role: str, hosted: Sequence[int]) -> list[Rule]:
    own = [key(run, robot) for robot in hosted for key in (keys.beacon, keys.command)]
    observations = [keys.observation(run, robot) for robot in hosted]
    beacons = keys.beacon(run, "*")  # who is in range changes each tick: the radio, not the router, decides
    welcome = keys.welcome(run, keys.span(hosted))
    return [
        _allow(f"{role} says", "ingress", ["put"], own),
        _allow(f"{role} is alive", "ingress", ["liveliness_token"], [keys.robot_alive(run, i) for i in hosted]),
        _allow(f"{role} listens", "ingress", ["declare_subscriber"], [*observations, beacons]),
        _allow(f"{role} hears", "egress", ["put"], [*observations, beacons]),
        _allow(f"{role} asks", "ingress", ["query"], [welcome]),
        _allow(f"{role} is answered", "egress", ["reply"], [welcome]),
        _allow(f"{role} recalls", "ingress", ["query"], [keys.held_beacon(run, "*", keys.span(hosted))]),
        _allow(f"{role} is recalled", "egress", ["reply"], [keys.held_beacon(run, "*", keys.span(hosted))]),
        _allow(f"{role} remembers", "ingress", ["declare_queryable", "reply"], [keys.recall(run, i) for i in hosted]),
        _allow(f"{role} is asked", "egress", ["query"], [keys.recall(run, i) for i in hosted]),
        _allow("robots watch", "ingress", ["declare_liveliness_subscriber"], [keys.world_alive(run)]),
        _allow("robots see", "egress", ["liveliness_token"], [keys.world_alive(run)]),
    ]


def _observer(run: str) -> list[Rule]:
    alive = [keys.world_alive(run), keys.robot_alive(run, "*")]
    return [
        _allow("observers listen", "ingress", ["declare_subscriber"], [keys.report(run)]),
        _allow("observers hear", "egress", ["put"], [keys.report(run)]),
        _allow("observers watch", "ingress", ["declare_liveliness_subscriber"], alive),
        _allow("observers see", "egress", ["liveliness_token"], alive),
        _allow("observers look", "ingress", ["liveliness_query"], [keys.tree(run)]),
        _allow("observers ask", "ingress", ["query"], [keys.about(run)]),
        _allow("observers are answered", "egress", ["reply"], [keys.about(run)]),
    ]


def _operator(run: str) -> list[Rule]:
    return [
        _allow("operators ask", "ingress", ["query"], [keys.change(run)]),
        _allow("operators are answered", "egress", ["reply"], [keys.change(run)]),
    ]


def _everything(run: str) -> Rule:
    """What the world may do, and is told: all that there is of its run."""
    said = ["put", "delete", "query", "reply", "liveliness_token", "liveliness_query"]
    declared = ["declare_subscriber", "declare_queryable", "declare_liveliness_subscriber"]
    return _allow("the world does all", "ingress", [*said, *declared], [keys.tree(run)]) | {
        "flows": ["ingress", "egress"]
    }


def _all_are_told(run: str) -> list[Rule]:
    """Who listens and who answers. Without it a publisher stays mute, and a forgery is not even tried, nor logged."""
    return [
        _allow("all are told who listens", "egress", ["declare_subscriber", "declare_queryable"], [keys.tree(run)])
    ]


def _allow(name: str, flow: str, messages: list[str], key_exprs: list[str]) -> Rule:
    return {"id": name, "permission": "allow", "flows": [flow], "messages": messages, "key_exprs": key_exprs}
