"""A session of MAVSDK: `mavsdk_session.py udp:PORT | tcp:HOST:PORT`. It prints what it asks for and what it gets."""

import math
import sys
import time
from collections.abc import Callable
from typing import Any

from mavsdk import ComponentType, Configuration, Mavsdk, MavsdkError
from mavsdk.plugins.action import Action
from mavsdk.plugins.component_metadata import ComponentMetadata
from mavsdk.plugins.geofence import Circle, FenceType, Geofence, GeofenceData, Point, Polygon
from mavsdk.plugins.mission import Mission, MissionItem, MissionPlan
from mavsdk.plugins.param import Param
from mavsdk.plugins.telemetry import FixType, Telemetry

PATIENCE = 60.0  # s, that an answer may take
WIRE = 115200.0  # bit/s of the serial line


def ask(request: Callable[[], Any]) -> Any:
    """Repeat a request until it is accepted: the client gives up sooner than a busy machine may answer."""
    end = time.monotonic() + PATIENCE
    while True:
        try:
            return request()
        except MavsdkError:
            if end < time.monotonic():
                raise
        time.sleep(0.3)


def until(condition: Callable[[], bool], what: str) -> None:
    """Wait until a condition holds."""
    end = time.monotonic() + PATIENCE
    while not condition():
        if end < time.monotonic():
            raise SystemExit(f"{what}: none in {PATIENCE:g} s")
        time.sleep(0.3)


def refused(request: Callable[[], Any], what: str) -> None:
    """Make a request that the robot must refuse."""
    end = time.monotonic() + PATIENCE
    result = "TIMEOUT"
    while result == "TIMEOUT" and time.monotonic() < end:
        try:
            request()
            raise SystemExit(f"{what} was accepted")
        except MavsdkError as error:
            result = str(error).partition(";")[0]
    print(f"{what}: {result}")
    assert result != "TIMEOUT"


def near(a: float, b: float) -> bool:
    return math.isclose(a, b, abs_tol=2e-7)


def connect(address: str) -> Any:
    kind, _, place = address.partition(":")
    url = f"udpin://127.0.0.1:{place}" if kind == "udp" else f"tcpout://{place}"
    sdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    print(f"connect {url}: {sdk.add_any_connection(url).name}")
    system = sdk.first_autopilot(PATIENCE)
    print(f"system {system.get_system_id()}, {system.autopilot_type().name}, {system.vehicle_type().name}")
    return sdk, system


def parameters(system: Any) -> None:
    param = Param(system)
    ask(lambda: param.set_param_float("LINK_RATE", WIRE))
    names = [one.name for one in ask(param.get_all_params).float_params]
    print(f"parameters: {len(names)}")
    assert "LEARNING" in names
    ask(lambda: param.set_param_float("LEARNING", 0.25))
    print(f"LEARNING = {ask(lambda: param.get_param_float('LEARNING')):g}")
    refused(lambda: param.set_param_float("LEARNING", 7.0), "LEARNING = 7")
    metadata, received = ComponentMetadata(system), []
    metadata.subscribe_metadata_available(lambda data, _: received.append(data))
    metadata.request_autopilot_component()
    until(lambda: any(data.json_metadata for data in received), "metadata")
    print(f"component metadata: {max(len(data.json_metadata) for data in received)} characters")


def geofence(system: Any, lat: float, lon: float) -> None:
    fence = Geofence(system)
    far = 4e-4
    points = [Point(lat + far * n, lon + far * e) for n, e in ((-1, -1), (-1, 1), (1, 1), (1, -1))]
    ask(lambda: fence.upload_geofence(GeofenceData([Polygon(points, FenceType.INCLUSION)], [])))
    found = ask(fence.download_geofence).polygons[0].points
    pairs = zip(points, found, strict=True)
    assert all(near(a.latitude_deg, b.latitude_deg) and near(a.longitude_deg, b.longitude_deg) for a, b in pairs)
    print(f"fence: {len(found)} corners up and down")
    circle = GeofenceData([], [Circle(points[0], 5.0, FenceType.EXCLUSION)])
    refused(lambda: fence.upload_geofence(circle), "exclusion")


def mission(system: Any, lat: float, lon: float) -> Any:
    service, none = Mission(system), math.nan

    def item(north: float, east: float, altitude: float, speed: float) -> MissionItem:
        gimbal, camera, action = (none, none), MissionItem.CameraAction.NONE, MissionItem.VehicleAction.NONE
        return MissionItem(
            lat + north, lon + east, altitude, speed, True, *gimbal, camera, none, none, 3.0, none, none, action
        )

    plan = [item(1e-4, 0, -0.5, 0.3), item(1e-4, 1e-4, -1.0, 0.25), item(0, 1e-4, -0.5, 0.3)]
    service.set_return_to_launch_after_mission(True)
    ask(lambda: service.upload_mission(MissionPlan(plan)))
    found = ask(service.download_mission).mission_items
    for a, b in zip(plan, found, strict=True):
        assert near(a.latitude_deg, b.latitude_deg)
        assert near(a.longitude_deg, b.longitude_deg)
        assert a.relative_altitude_m == b.relative_altitude_m
        assert near(a.speed_m_s, round(b.speed_m_s, 6))
    print(f"mission: {len(found)} items up and down, then the way home: {service.get_return_to_launch_after_mission()}")
    return service


def main(address: str) -> None:
    sdk, system = connect(address)
    parameters(system)
    telemetry, action = Telemetry(system), Action(system)
    until(lambda: not math.isnan(telemetry.position().latitude_deg), "position")
    at = telemetry.position()
    print(f"position {at.latitude_deg:.6f} {at.longitude_deg:.6f}, {at.relative_altitude_m:.2f} m")
    until(lambda: telemetry.gps_info().fix_type != FixType.NO_GPS, "receiver")
    print(f"satellite receiver: {telemetry.gps_info().fix_type.name}")
    geofence(system, at.latitude_deg, at.longitude_deg)
    service = mission(system, at.latitude_deg, at.longitude_deg)
    ask(action.arm)
    until(telemetry.armed, "armed")
    print("armed")
    for name, order in (
        ("start", service.start_mission),
        ("pause", service.pause_mission),
        ("start", service.start_mission),
        ("return", action.return_to_launch),
        ("surface", action.land),
    ):
        ask(order)
        print(f"{name}: accepted, item {service.mission_progress().current} of {service.mission_progress().total}")
    ask(action.disarm)
    until(lambda: not telemetry.armed(), "disarmed")
    print("disarmed")
    ask(service.clear_mission)
    ask(Geofence(system).clear_geofence)
    print("mission and fence cleared")
    sdk.destroy()


if __name__ == "__main__":
    main(sys.argv[1])
