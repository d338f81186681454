"""The process fes-robot: a real robot, from its file to the end of its run."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: no thread pool for arrays this small
os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # else pydantic reads the metadata of all distributions

import argparse
import contextlib
import logging
import secrets
from pathlib import Path

from fes import command_line, process
from fes.errors import FesError, reason
from fes.protocol import keys
from fes.protocol.robot_report import MAX_BOOT
from fes.recording.robot_log import layout
from fes.recording.robot_log.layout import Header
from fes.recording.robot_log.recorder import RobotLog
from fes.system import output
from fes.transport import bus, identity
from fes.transport.endpoints import Endpoints
from field.gate import launch
from field.radio.socket import Radio
from field.runtime import robot as robots
from field.runtime.robot import Robot
from field.settings import robot_file
from field.settings.for_gate import gate_settings
from field.settings.robot_file import RobotFile


async def serve(flags: argparse.Namespace) -> int:
    """Run one robot until it is told to end, and return its exit code."""
    file = robot_file.load(flags.file, flags.id)
    robot = robots.checked_id(file)
    security = identity.security(flags.keys, identity.robot_role((robot,)))
    settings = gate_settings(file, robot, remote=flags.remote_body, security=security, patience=flags.timeout)
    radio_settings = file.radio.settings(flags.file.parent)
    boot, logger = secrets.randbelow(MAX_BOOT), logging.getLogger(f"robot.{robot}")
    team = Endpoints("client", (file.team.endpoint,), timeout=flags.timeout, security=security)
    logger.info("waiting for the driver at %s and the team's network at %s", file.body.endpoint, file.team.endpoint)
    async with contextlib.AsyncExitStack() as stack:
        gate = await stack.enter_async_context(await launch.launch(settings))
        opened = await stack.enter_async_context(bus.opened(team))
        publish = opened.declare_publisher(keys.robot_report(file.run, robot), "RobotReport", drop=True)
        living = Robot(file, robot, boot, publish)
        radio = stack.enter_context(await Radio.opened(radio_settings, file.run, robot, living.hear))
        log = stack.enter_context(_log(flags.out, file, robot, boot)) if flags.out else None
        opened.declare_token(keys.robot_alive(file.run, robot))
        logger.info("ready: run '%s', team network at %s", file.run, file.team.endpoint)
        try:
            await living.live(gate, radio, log)
        finally:
            await gate.close()  # first: it stops the robot, while a log or a session may take seconds to close
            logger.info("%s", robots.summary(living, radio))
    return process.SUCCESS


def _log(folder: Path, file: RobotFile, robot: int, boot: int) -> RobotLog:
    """The log of a robot, in a file of its own in `folder`; raises FesError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path = layout.new_path(folder, robot)
    except OSError as error:
        raise FesError(f"cannot write a log in {folder}: {reason(error, with_file=False)}") from None
    return RobotLog(path, Header.now(file.run, robot, f"{boot:016x}", file.agent_config, scale=file.body.scale))


def main() -> None:
    """Entry point of fes-robot."""
    output.configure()
    parser = command_line.OneLineParser(
        prog="fes-robot",
        description="Run one real robot: its law, its radio, and the gate that guards its wheels.",
        epilog="example: fes-robot robot.toml --id 3",
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="settings of the robot, such as robot.toml")
    parser.add_argument("--id", type=_robot, metavar="I", help="id of the robot; overrides `id` in the file")
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder of the robot's log (default: no log)")
    parser.add_argument(
        "--keys",
        type=Path,
        metavar="DIR",
        help="use TLS on the team's network, with certificates of this folder",
    )
    parser.add_argument(
        "--remote-body",
        action="store_true",
        help="accept a driver on another machine, which may obey old commands after a network cut",
    )
    parser.add_argument(
        "--timeout",
        type=command_line.seconds,
        default=30.0,
        metavar="S",
        help="longest wait for the Zenoh routers of the driver and of the team (default: %(default)g s)",
    )
    command_line.add_use_flag(parser)
    parser.add_argument("--exit-with-stdin", action="store_true", help="stop when standard input ends")
    flags = parser.parse_args()
    process.run("fes-robot", lambda: serve(flags), exit_with_stdin=flags.exit_with_stdin)


def _robot(text: str) -> int:
    """The value of --id; raises ArgumentTypeError."""
    try:
        [robot] = keys.parse_span(text, "--id", "I")
    except (FesError, ValueError):
        raise argparse.ArgumentTypeError(f"expects 0 to {keys.MAX_ROBOTS - 1}, got '{text}'") from None
    return robot


if __name__ == "__main__":
    main()
