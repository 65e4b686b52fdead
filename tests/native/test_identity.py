# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One image, bit for bit, whatever makes it; and the safeguards without which it is not."""

from collections import Counter
from pathlib import Path

import identity
import isa
import pytest
import variants

#: The scene on which each safeguard is missed.
MISSED = {
    "WHITTLE_BREAK_PADDING": "pixel_net",
    "WHITTLE_BREAK_CLAMP": "grazed_sheets",
    "WHITTLE_BREAK_TIE": "duplicates",
}


@pytest.mark.parametrize("name", identity.SCENES)
def test_image_is_one(name: str) -> None:
    """Instruction sets, threads, packet sizes, modes, bins, leaf sizes: each pair agrees."""
    images: dict[str, str] = {}
    for set_ in isa.ISAS:
        with isa.process(set_) as run:
            for way, found in run(identity.digests, name).items():
                images[f"{set_}, {way}"] = found
            again = run(identity.digests, name, (160, 100), True)
            images |= {f"{set_} again, {way}": found for way, found in again.items()}
    counts = Counter(images.values())
    odd = {way: found for way, found in images.items() if found != counts.most_common(1)[0][0]}
    assert len(images) > 80 * len(isa.ISAS)
    assert not odd


def test_full_size_image_is_one() -> None:
    images = {}
    for set_ in isa.ISAS:
        with isa.process(set_) as run:
            for way, found in run(identity.full_size, "spheres").items():
                images[f"{set_}, {way}"] = found
    assert len(set(images.values())) == 1, images


def test_images_show_something() -> None:
    """The scenes fill their images, with many colours, and differ from each other."""
    seen = set()
    for name, make in identity.SCENES.items():
        scene, view = make()
        scene.build()
        camera = identity.perspective(160, 100, **view)
        image = scene.render(camera, {"passes": identity.PASSES})
        covered = (image["object_index"] > 0).mean()
        colours = len(set(map(bytes, image["combined"].reshape(-1, 4))))
        assert covered > 0.1, f"{name}: {covered:.0%} covered"
        assert colours > 500, f"{name}: {colours} colours"
        seen.add(identity.digest(image))
    assert len(seen) == len(identity.SCENES)


@pytest.fixture(scope="module")
def builds(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    return variants.without(["", *MISSED], tmp_path_factory.mktemp("variants"))


@pytest.mark.parametrize("switch", MISSED)
def test_safeguard_is_needed(builds: dict[str, Path], switch: str) -> None:
    """With the safeguard taken out at compile time, the check above fails on its scene."""
    width = [name for name in isa.ISAS if name != "avx512"][-1]
    with isa.process(width, builds[switch]) as run:
        found = set(run(identity.digests, MISSED[switch], (160, 100), True).values())
    assert len(found) > 1, f"without {switch} the image is still the same everywhere"


def test_variant_as_it_is_agrees(builds: dict[str, Path]) -> None:
    """The variants' own way of building does not matter: unchanged, it gives the one image."""
    width = [name for name in isa.ISAS if name != "avx512"][-1]
    for name in set(MISSED.values()):
        with isa.process(width, builds[""]) as run:
            found = set(run(identity.digests, name, (160, 100), True).values())
        with isa.process(width) as run:
            right = set(run(identity.digests, name, (160, 100), True).values())
        assert found == right and len(found) == 1
