"""Motion of all grains of a crystal: rotations, outward and inward motion of rows, symmetry, and
speeds seen by a camera.
"""

import numpy as np
from scipy.signal import find_peaks
from scipy.spatial import cKDTree

# diameters
SAME = 1e-6
IN_ROW = 0.01
# fraction of the first peak: speed before a second pulse, and its smallest prominence
QUIET = 0.25
SMALL = 0.05


class Motion:
    """Motion of a crystal, positions and times in m and s."""

    def __init__(self, crystal):
        self.crystal = crystal
        self.diameter = crystal.case.packing.diameter
        self.time, self.position, self.displacement, self.rate = (
            crystal.run.result[f"lines/all/{name}"]
            for name in ("time", "position", "displacement", "angular_velocity")
        )
        self.x = self.position[:, 0]
        self.middle = 0.5 * (self.x.min() + self.x.max())

    def turned(self):
        """Largest rotations of the grains at side walls, and of the other grains, degrees."""
        rate = self.rate[:, :, 1]
        angle = np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(self.time)[:, None], axis=0)
        largest = np.degrees(np.abs(angle).max(axis=0))
        at_walls = (self.x < self.x.min() + SAME) | (self.x > self.x.max() - SAME)
        return largest[at_walls].max(), largest[~at_walls].max()

    def row_shift(self, when):
        """Mean outward displacement of the left half of the second row at a time, um."""
        depth = self.position[:, 2] / self.diameter
        second = np.abs(depth - np.unique(np.round(depth, 3))[1]) < IN_ROW
        aside = -self.displacement[:, second & (self.x < self.middle - SAME), 0]
        return np.interp(when, self.time, 1e6 * aside.mean(axis=1))

    def mirrored(self):
        """Largest difference of the displacements of mirrored grains, in diameters."""
        image = self.position.copy()
        image[:, 0] = 2 * self.middle - image[:, 0]
        partner = cKDTree(self.position).query(image)[1]
        moved = self.displacement
        across = moved[:, :, 0] + moved[:, partner, 0]
        down = moved[:, :, 2] - moved[:, partner, 2]
        return max(np.abs(across).max(), np.abs(down).max()) / self.diameter

    def seen_by_camera(self, rate):
        """Smallest and largest ratio of the largest speed seen in frames (``rate`` per second) to
        the true largest speed, along the middle line.

        A camera sees displacements, and thus the mean velocity between two frames.
        """
        time, moved = (
            self.crystal.run.result[f"lines/down/{name}"] for name in ("time", "displacement")
        )
        frames = np.arange(0.0, time[-1], 1 / rate)
        moved = moved[:, :, ::2].transpose(1, 2, 0)  # sideways and down, in the plane
        places = np.array([[np.interp(frames, time, one) for one in grain] for grain in moved])
        shown = np.linalg.norm(np.diff(places, axis=2) * rate, axis=1).max(axis=1)
        ratio = shown / self.crystal.down.largest_speed
        return ratio.min(), ratio.max()


def later_peak(crystal):
    """Time of the second pulse's peak in the deepest grains that are not held by the floor, s."""
    time, velocity = (crystal.run.result[f"lines/down/{name}"] for name in ("time", "velocity"))
    speed = np.linalg.norm(velocity, axis=2)
    found = []
    for one in speed.T[len(crystal.depth) // 2 : crystal.down.fitted.stop]:
        first = one.argmax()
        low = np.flatnonzero(one[first:] < QUIET * one[first])
        rest = first + low[0] if low.size else len(one)
        peaks = rest + find_peaks(one[rest:], prominence=SMALL * one[first])[0]
        found += [time[peaks[one[peaks].argmax()]]] if len(peaks) else []
    return np.median(found)
