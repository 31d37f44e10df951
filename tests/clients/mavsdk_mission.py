"""MAVSDK (native or gRPC): discovery, health, parameters, a mission up and down, armed, paused, run to the end, RTL.

    mavsdk_mission.py native|grpc ADDRESS PLAN [watch]

With `watch` it only looks on while another ground station drives.
"""

import asyncio
import math
import socket
import sys
import time
from types import SimpleNamespace

from quiet import Stopwatch

PATIENCE = 90.0
"""Seconds of real time after which a wait is hopeless."""
DISCOVERY = 1.0
"""Seconds within which MAVSDK has to find the boat."""
GLANCE = 0.05
"""Seconds between two looks at something that MAVSDK has no stream for."""
FOUND_WITHIN = 1.0
"""Seconds of real time within which a quiet machine has found the boat."""
PLUGINS = ("Action", "MissionRaw", "Param", "Telemetry")


async def connect_native(address):
    """The boat's plugins by MAVSDK's native Python bindings."""
    import importlib

    from mavsdk.asyncio import ComponentType, Configuration, Mavsdk

    mavsdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    started = Stopwatch()
    await mavsdk.add_any_connection(address)
    system = await mavsdk.first_autopilot(PATIENCE)
    found_s = started.within(FOUND_WITHIN, "discovery")
    plugins = {"mavsdk": mavsdk, "system": system}
    for plugin in PLUGINS:
        module = "".join("_" + letter.lower() if letter.isupper() else letter for letter in plugin).lstrip("_")
        plugins[module] = getattr(importlib.import_module(f"mavsdk.asyncio.plugins.{module}"), plugin + "Async")(system)
    client = SimpleNamespace(**plugins)
    client.stream = lambda plugin, name: getattr(plugin, f"subscribe_{name}")()
    return client, found_s


async def connect_grpc(address):
    """The boat's plugins by mavsdk-grpc, which starts a mavsdk_server of its own."""
    from mavsdk_grpc import System

    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    system = System(port=port)
    await system.connect(system_address=address)
    started = Stopwatch()
    await first(system.core.connection_state(), lambda state: state.is_connected, "a connection")
    found_s = started.within(FOUND_WITHIN, "discovery")
    client = SimpleNamespace(
        system=system, action=system.action, mission_raw=system.mission_raw, param=system.param,
        telemetry=system.telemetry)
    client.stream = lambda plugin, name: getattr(plugin, name)()
    return client, found_s


async def first(stream, condition, what):
    """The first value of a stream for which the condition holds."""
    last = None

    async def search():
        nonlocal last
        async for last in stream:
            if condition(last):
                return last
        raise AssertionError(f"the stream ended while waiting for {what}")

    try:
        return await asyncio.wait_for(search(), PATIENCE)
    except asyncio.TimeoutError:
        raise AssertionError(f"waited in vain for {what}; the last was {last}") from None


async def health(client):
    """Everything is healthy, home is known, the boat can be armed."""
    def well(health):
        return all(
            getattr(health, f"is_{part}") for part in (
                "gyrometer_calibration_ok", "accelerometer_calibration_ok", "magnetometer_calibration_ok",
                "global_position_ok", "local_position_ok", "home_position_ok", "armable"))

    await first(client.stream(client.telemetry, "health"), well, "health")
    return await first(client.stream(client.telemetry, "position"), lambda _: True, "a position")


async def parameters(client):
    """All of them, one read by name."""
    everything = await client.param.get_all_params()
    assert await client.param.get_param_int("SYSID_MYGCS") == 255
    return len(everything.int_params) + len(everything.float_params)


async def change_parameters(client):
    """One of each kind, as it is read back."""
    await client.param.set_param_float("WP_RADIUS", 1.5)
    assert await client.param.get_param_float("WP_RADIUS") == 1.5
    await client.param.set_param_int("FS_ACTION", 1)
    assert await client.param.get_param_int("FS_ACTION") == 1


async def mission(client, plan):
    """The plan file on board, and the same when read back."""
    items = (await client.mission_raw.import_mission_planner_mission(plan)).mission_items
    await client.mission_raw.upload_mission(items)
    stored = await client.mission_raw.download_mission()
    assert len(stored) == len(items), f"{len(stored)} items on board, {len(items)} sent"
    for wanted, got in list(zip(items, stored))[1:]:
        for field in ("seq", "frame", "command", "param1", "param2", "x", "y"):
            assert getattr(got, field) == getattr(wanted, field), f"{field}: {got} for {wanted}"
    return items


async def reach(client, item):
    """Waits until the boat is under way to this item, or past it."""
    progress = client.stream(client.mission_raw, "mission_progress")
    return await first(progress, lambda progress: progress.current >= item, f"item {item}")


async def flight_mode(client, name):
    """Waits for a flight mode."""
    modes = client.stream(client.telemetry, "flight_mode")
    await first(modes, lambda mode: mode.name.replace("_", "") == name.replace("_", ""), f"mode {name}")


def distance_m(home, position):
    """Distance from a mission item to a position, good for a harbour."""
    north = math.radians(position.latitude_deg - home.x / 1e7)
    east = math.radians(position.longitude_deg - home.y / 1e7) * math.cos(math.radians(home.x / 1e7))
    return 6_371_000.0 * math.hypot(north, east)


async def finished(client):
    """Waits until the mission is complete."""
    deadline = time.monotonic() + PATIENCE
    while not await client.mission_raw.is_mission_finished():
        assert time.monotonic() < deadline, "the mission never was finished"
        await asyncio.sleep(GLANCE)


async def drive(client, plan):
    """Runs the mission with a pause in it, then goes home."""
    await change_parameters(client)
    items = await mission(client, plan)
    await client.action.arm()
    await first(client.stream(client.telemetry, "armed"), lambda armed: armed, "the boat being armed")
    await client.mission_raw.start_mission()
    await flight_mode(client, "MISSION")
    await reach(client, 3)
    await client.mission_raw.pause_mission()
    await flight_mode(client, "HOLD")
    speeds = client.stream(client.telemetry, "velocity_ned")
    await first(speeds, lambda v: math.hypot(v.north_m_s, v.east_m_s) < 0.2, "the boat lying still")
    await client.mission_raw.start_mission()
    progress = await reach(client, len(items))
    assert progress.total == len(items), f"{progress.total} items"
    await finished(client)
    print("reached the end of the mission")

    await client.action.return_to_launch()
    await flight_mode(client, "RETURN_TO_LAUNCH")
    positions = client.stream(client.telemetry, "position")
    await first(positions, lambda position: distance_m(items[0], position) < 3.0, "the boat being at home")
    await client.action.disarm()
    print("back home")


async def watch(client):
    """Sees another ground station's mission end, and reads it."""
    texts = client.stream(client.telemetry, "status_text")
    await first(texts, lambda message: message.text == "Mission Complete", "the boat saying that it is done")
    print(f"saw the mission end, {len(await client.mission_raw.download_mission())} items on board")


async def main():
    kind, address, plan, *role = sys.argv[1:]
    client, found_s = await {"native": connect_native, "grpc": connect_grpc}[kind](address)
    print(f"found the boat after {found_s:.2f} s")
    assert found_s <= DISCOVERY, f"{found_s:.2f} s to find the boat"
    await health(client)
    print(f"{await parameters(client)} parameters")
    if role == ["watch"]:
        await watch(client)
    else:
        await drive(client, plan)


asyncio.run(main())
