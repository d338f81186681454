"""Zenoh's access control: the keys on which each role may publish and receive, from the table of keys.

Zenoh checks each message that enters or leaves the world's router. The common name on the certificate of the link
selects the rules. A message that no rule allows is denied. The world's own messages cross no link, so no rule applies
to them. If the router is another process, the world is one more role, which may publish and receive everything.

| role        | may publish                   | may receive                                  | may query            |
|-------------|-------------------------------|----------------------------------------------|----------------------|
| robot-<ids> | own beacons, commands, tokens | own observations, beacons, the world's token | welcome, lost beacon |
| observer    | nothing                       | reports, all tokens                          | world info           |
| operator    | nothing                       | reports, all tokens                          | world info, a change |

A team of real robots has no world. The rules of its router, `fes team router` or one with the configuration that
`fes keys rules` prints, allow in addition:

| role        | may publish          | may receive | may query         | may answer          |
|-------------|----------------------|-------------|-------------------|---------------------|
| robot-<ids> | own reports, tokens  | permits     | own gate's token  | start, stop, status |
| observer    | nothing              | reports     | status            | nothing             |
| operator    | permits              | reports     | status, start, stop | nothing           |

A gate queries its own token, because a robot has one gate: a second one, started by mistake, must end.
"""

from collections.abc import Iterable, Sequence
from typing import Any

from fes.protocol import keys
from fes.transport.identity import OBSERVER, OPERATOR, WORLD, robot_role

Rule = dict[str, object]


def control(run: str, robots: int, crews: Iterable[Sequence[int]] = (), *, world: bool = False) -> dict[str, object]:
    """The access control of a run of `robots` robots, each with an agent of its own or hosted by one of `crews`.

    With `world`, the settings are for a router in another process. The world then connects to it by a link too, as do
    further routers, which present the world's certificate.
    """
    hosted_by: dict[str, Sequence[int]] = {robot_role([robot]): range(robot, robot + 1) for robot in range(robots)}
    hosted_by |= {robot_role(crew): crew for crew in crews if crew[-1] < robots}
    declarations = _declarations(run)
    rules = {role: [*_robot(run, role, hosted), *declarations] for role, hosted in hosted_by.items()}
    rules[OBSERVER] = [*_observer(run), *declarations]
    rules[OPERATOR] = [*rules[OBSERVER], *_operator(run)]
    if world:
        rules[WORLD] = [_everything(run)]
    by_id = {str(rule["id"]): rule for of_role in rules.values() for rule in of_role}
    settings = {
        "enabled": True,
        "default_permission": "deny",
        "rules": list(by_id.values()),
        "subjects": [{"id": role, "cert_common_names": [role]} for role in rules],
        "policies": [
            {"subjects": [role], "rules": [rule["id"] for rule in of_role]} for role, of_role in rules.items()
        ],
    }
    return {"access_control": settings}


def roles(settings: dict[str, object]) -> list[str]:
    """The roles in settings that `control` returned."""
    control: Any = settings["access_control"]
    return [subject["id"] for subject in control["subjects"]]


def _robot(run: str, role: str, hosted: Sequence[int]) -> list[Rule]:
    own = [key(run, robot) for robot in hosted for key in (keys.beacon, keys.command, keys.robot_report)]
    gates = [keys.gate_alive(run, robot) for robot in hosted]
    tokens = [*(keys.robot_alive(run, robot) for robot in hosted), *gates]
    asked = [key(run, robot) for robot in hosted for key in (keys.gate_start, keys.gate_stop, keys.gate_status)]
    observations = [keys.observation(run, robot) for robot in hosted]
    beacons = keys.beacon(run, "*")  # peers in range change each tick: the radio decides, not the router
    welcome = keys.welcome(run, keys.span(hosted))
    return [
        _allow(f"{role} publishes", "ingress", ["put"], own),
        _allow(f"{role} is alive", "ingress", ["liveliness_token"], tokens),
        _allow(f"{role} asks for another gate of its own", "ingress", ["liveliness_query"], gates),
        _allow(f"{role} learns of another gate of its own", "egress", ["liveliness_token"], gates),
        _allow(f"{role} subscribes", "ingress", ["declare_subscriber"], [*observations, beacons]),
        _allow(f"{role} receives", "egress", ["put"], [*observations, beacons]),
        _allow(f"{role} joins", "ingress", ["query"], [welcome]),
        _allow(f"{role} is welcomed", "egress", ["reply"], [welcome]),
        _allow(f"{role} recalls", "ingress", ["query"], [keys.held_beacon(run, "*", keys.span(hosted))]),
        _allow(f"{role} gets recalled beacons", "egress", ["reply"], [keys.held_beacon(run, "*", keys.span(hosted))]),
        _allow(
            f"{role} serves recalls", "ingress", ["declare_queryable", "reply"], [keys.recall(run, i) for i in hosted]
        ),
        _allow(f"{role} gets recalls", "egress", ["query"], [keys.recall(run, i) for i in hosted]),
        _allow(f"{role} answers an operator", "ingress", ["declare_queryable", "reply"], asked),
        _allow(f"{role} gets queries of an operator", "egress", ["query"], asked),
        _allow("robots subscribe to permits", "ingress", ["declare_subscriber"], [keys.permit(run)]),
        _allow("robots get permits", "egress", ["put"], [keys.permit(run)]),
        _allow("robots watch the world", "ingress", ["declare_liveliness_subscriber"], [keys.world_alive(run)]),
        _allow("robots see the world", "egress", ["liveliness_token"], [keys.world_alive(run)]),
    ]


def _observer(run: str) -> list[Rule]:
    alive = [keys.world_alive(run), keys.robot_alive(run, "*"), keys.gate_alive(run, "*")]
    reports, status = [keys.report(run), keys.robot_report(run, "*")], [keys.gate_status(run, "*")]
    return [
        _allow("observers subscribe", "ingress", ["declare_subscriber"], reports),
        _allow("observers receive", "egress", ["put"], reports),
        _allow("observers ask gates for their state", "ingress", ["query"], status),
        _allow("observers get the state of gates", "egress", ["reply"], status),
        _allow("observers watch tokens", "ingress", ["declare_liveliness_subscriber"], alive),
        _allow("observers see tokens", "egress", ["liveliness_token"], alive),
        _allow("observers query tokens", "ingress", ["liveliness_query"], [keys.tree(run)]),
        _allow("observers query world info", "ingress", ["query"], [keys.about(run)]),
        _allow("observers get world info", "egress", ["reply"], [keys.about(run)]),
    ]


def _operator(run: str) -> list[Rule]:
    motion = [keys.gate_start(run, "*"), keys.gate_stop(run, "*")]
    return [
        _allow("operators permit robots to move", "ingress", ["put"], [keys.permit(run)]),
        _allow("operators start and stop robots", "ingress", ["query"], motion),
        _allow("operators get the answers of gates", "egress", ["reply"], motion),
        _allow("operators change the channel", "ingress", ["query"], [keys.change(run)]),
        _allow("operators get results", "egress", ["reply"], [keys.change(run)]),
    ]


def _everything(run: str) -> Rule:
    """The rule of the world: every message on the keys of its run, in both directions."""
    published = ["put", "delete", "query", "reply", "liveliness_token", "liveliness_query"]
    declared = ["declare_subscriber", "declare_queryable", "declare_liveliness_subscriber"]
    return _allow("the world", "ingress", [*published, *declared], [keys.tree(run)]) | {
        "flows": ["ingress", "egress"]
    }


def _declarations(run: str) -> list[Rule]:
    """The rule by which each role sees subscribers and queryables.

    Without it a publisher sees no subscriber and sends nothing, so a forgery would not even be logged.
    """
    return [_allow("all see declarations", "egress", ["declare_subscriber", "declare_queryable"], [keys.tree(run)])]


def _allow(name: str, flow: str, messages: list[str], key_exprs: list[str]) -> Rule:
    return {"id": name, "permission": "allow", "flows": [flow], "messages": messages, "key_exprs": key_exprs}
