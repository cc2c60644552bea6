"""The navigation of a replay as messages of ROS 2 in one MCAP file, with the package rosbags.

    /truenorth/fix        sensor_msgs/NavSatFix   position of the IMU, variances east, north, up
    /truenorth/odometry   nav_msgs/Odometry       pose in `map`, east, north, up of the first position; twist
                                                  in `base_link`, which points forward, left, up (REP 103)

Stamps are UTC, or seconds of the recording's own clock where its date is not known. What is not estimated has
the covariance 0: of the pose roll and pitch, which no sigma is told of, and of the twist the body rates.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from sim_scenarios.attitude import dcm
from sim_scenarios.earth import displacement
from sim_scenarios.folders import filling_temporary, temporary
from sim_scenarios.recordings import track
from sim_scenarios.recordings.clocks import leap_seconds
from sim_scenarios.recordings.readers.extras import needed
from sim_scenarios.recordings.readers.gps_time import SINCE_1970
from sim_scenarios.units import DEGREE

Array = NDArray[np.float64]

FIX: Final = "sensor_msgs/msg/NavSatFix"
ODOMETRY: Final = "nav_msgs/msg/Odometry"
TOPICS: Final = {FIX: "/truenorth/fix", ODOMETRY: "/truenorth/odometry"}

_KNOWN_VARIANCES: Final = 2
"""COVARIANCE_TYPE_DIAGONAL_KNOWN of NavSatFix."""
_BODY: Final = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""Forward, left, up of right, forward, up."""
_VERSION: Final = 9
"""Of the description that a bag has."""


def write(run: xr.Dataset, path: Path) -> None:
    """Write the navigation of a replay.

    Parameters
    ----------
    run : Dataset
        Of `recordings.replay`.
    path : Path
        The file.

    Raises
    ------
    InputError
        rosbags is not installed.
    """
    bags, types = packages()
    store = types.get_typestore(types.Stores.ROS2_HUMBLE)
    with TemporaryDirectory(dir=temporary()) as place:
        folder = Path(place) / "bag"
        with (
            filling_temporary(),
            bags.Writer(folder, version=_VERSION, storage_plugin=bags.StoragePlugin.MCAP) as bag,
        ):
            connections = {
                kind: bag.add_connection(topic, kind, typestore=store) for kind, topic in TOPICS.items()
            }
            for seconds, nanoseconds, messages in zip(*_stamps(run), _messages(run, store), strict=True):
                for kind, message in messages.items():
                    message.header.stamp.sec, message.header.stamp.nanosec = seconds, nanoseconds
                    stamp = seconds * 10**9 + nanoseconds
                    bag.write(connections[kind], stamp, store.serialize_cdr(message, kind))
        (file,) = folder.glob("*.mcap")
        path.write_bytes(file.read_bytes())


def packages() -> tuple[Any, Any]:
    """What writes bags, and what knows the types of messages.

    Raises
    ------
    InputError
        rosbags is not installed.
    """
    bags, types = (needed(f"rosbags.{part}", "rosbags", "writing MCAP") for part in ("rosbag2", "typesys"))
    return bags, types


def _stamps(run: xr.Dataset) -> tuple[list[int], list[int]]:
    """Seconds and nanoseconds of the stamps."""
    epoch = run.attrs.get("epoch")
    begin = 0.0
    if epoch is not None:
        since_1970 = epoch + SINCE_1970
        begin = since_1970 - leap_seconds(since_1970)
    whole = int(np.floor(begin))
    nanoseconds = np.rint((run["time"].values + (begin - whole)) * 1e9).astype(np.int64)
    seconds, rest = np.divmod(nanoseconds, 10**9)
    return (seconds + whole).tolist(), rest.tolist()


def _messages(run: xr.Dataset, store: Any) -> Iterator[dict[str, Any]]:
    """Messages of each instant by their type, without their stamps."""
    kinds = {name.rpartition("/")[2]: kind for name, kind in store.types.items()}
    place = track.positions(run)
    way = displacement(place, np.broadcast_to(place[0], place.shape))
    C_bn = dcm(*(run[f"nav.{name}"].values for name in ("roll", "pitch", "heading"))) @ _BODY.T
    quaternions = Rotation.from_matrix(C_bn).as_quat()
    velocity = np.einsum("kij,ki->kj", C_bn, run["nav.velocity"].values)
    variances = np.einsum("kij,ki,kil->kjl", C_bn, run["velocity_sigma"].values ** 2, C_bn)

    def three(name: str, values: Array) -> Any:
        return kinds[name](*values.tolist())

    nothing = np.zeros(3)
    for k, (latitude, longitude, height) in enumerate(place.tolist()):
        of_position = np.diag(run["position_sigma"].values[k] ** 2)
        of_pose, of_twist = np.zeros((6, 6)), np.zeros((6, 6))
        of_pose[:3, :3], of_twist[:3, :3] = of_position, variances[k]
        of_pose[5, 5] = run["heading_sigma"].values[k] ** 2
        pose = kinds["Pose"](three("Point", way[k]), kinds["Quaternion"](*quaternions[k].tolist()))
        twist = kinds["Twist"](three("Vector3", velocity[k]), three("Vector3", nothing))
        header = [kinds["Header"](kinds["Time"](0, 0), frame) for frame in ("base_link", "map")]
        yield {
            FIX: kinds["NavSatFix"](
                header[0],
                kinds["NavSatStatus"](status=0, service=1),
                latitude / DEGREE,
                (longitude / DEGREE + 180) % 360 - 180,
                height,
                of_position.ravel(),
                _KNOWN_VARIANCES,
            ),
            ODOMETRY: kinds["Odometry"](
                header[1],
                "base_link",
                kinds["PoseWithCovariance"](pose, of_pose.ravel()),
                kinds["TwistWithCovariance"](twist, of_twist.ravel()),
            ),
        }
