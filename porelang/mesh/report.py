"""What is told of a mesh that was made: its numbers, and the same in lines."""

from __future__ import annotations

from typing import Any

from porelang.data import coordinates
from porelang.mesh.crumbs import SLIVER
from porelang.mesh.surface import Surface
from porelang.walls import RESOLUTION

#: Pieces and voids that the report names; --json has more.
TOLD = 4
#: What a voxel is found from.
NARROW = (("thinnest walls", "wall"), ("narrowest gaps", "gap"))


def facts(surface: Surface) -> dict[str, Any]:
    """What a mesh is, in mm, mm2 and mm3."""
    lo, hi = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    return {
        "triangles": len(surface.faces),
        "vertices": len(surface.vertices),
        "volume": surface.volume,
        "area": surface.area,
        "bounds": [lo.tolist(), hi.tolist()],
    }


def text(path: str, found: dict[str, Any]) -> str:
    """The report, a line for each fact; `found` holds those of the mesh and of how it was made."""
    lo, hi = found["bounds"]
    size = " x ".join(f"{b - a:.4g}" for a, b in zip(lo, hi, strict=True))
    lines = {
        "triangles": f"{found['triangles']:,}",
        "volume": f"{found['volume']:.6g} mm3",
        "area": f"{found['area']:.6g} mm2",
        "size": f"{size} mm",
        "from": f"{', '.join(f'{v:.5g}' for v in lo)}",
        "to": f"{', '.join(f'{v:.5g}' for v in hi)}",
        "voxel": _voxel(found),
        "surfaces": f"{found['components']}{'' if found['components'] == 1 else ' that are not joined'}",
        "time": f"{found['seconds']:.2f} s ({found['backend']}, {found['dtype']})",
    }
    if found["components"] > 1:
        lines["pieces"] = _pieces(found["solids"], found["solid_pieces"])
        if found["voids"]:
            lines["voids"] = _pieces(found["voids"], found["closed_voids"])
    if told := _crumbs(found["crumbs"], found["voxel"]):
        lines["crumbs"] = told
    if "off_surface" in found:
        stayed = f"; {found['kept']} of them not on it" if found["kept"] else ""
        lines["vertices"] = f"at most {found['off_surface']:.2g} mm off the field{stayed}"
    if "rim_edges" in found:
        lines["rims"] = f"{found['rim_edges']:,} edges on them, {found['corners']:,} corners"
    if "deviation" in found:
        lines["simplified"] = f"from {found['triangles_before']:,} triangles, {found['deviation']:.3g} mm off at most"
    return "\n".join([path, *(f"  {name:<10} {value}" for name, value in lines.items())])


def _voxel(found: dict[str, Any]) -> str:
    """The voxel, and where it was not given how it was found."""
    text = f"{found['voxel']:.4g} mm"
    if "wall" not in found:
        return text
    if found["wall"] is None and found["gap"] is None:
        return f"{text} (by itself: 1/{RESOLUTION} of the longest side; no walls were found to measure)"
    told = " and ".join(f"the {kind} are about {found[key]:.2g} mm" for kind, key in NARROW if found[key] is not None)
    if found["voxel"] <= found["voxel_for_wall"] * (1 + 1e-9):
        return f"{text} (by itself: {told})"
    return f"{text} (by itself, and too coarse: {told} and want {found['voxel_for_wall']:.2g} mm; give it with --voxel)"


def _pieces(count: int, pieces: list[dict[str, Any]]) -> str:
    """How many pieces there are, and the first few: the volume of each and where its middle is."""
    told = []
    for piece in pieces[:TOLD]:
        lo, hi = piece["bounds"]
        middle = coordinates([(a + b) / 2 for a, b in zip(lo, hi, strict=True)])
        told.append(f"{piece['volume']:.4g} mm3 round ({middle})")
    more = f"; and {count - TOLD} more" if count > TOLD else ""
    return f"{count}: {'; '.join(told)}{more}"


def _crumbs(crumbs: dict[str, Any], voxel: float) -> str:
    """What sampling made, or what is far below it, and was taken out or filled again."""
    told = []
    if n := crumbs["removed"]:
        told.append(
            f"{n} speck{'' if n == 1 else 's'} of the part's edges taken out ({crumbs['removed_volume']:.2g} mm3)"
        )
    if n := crumbs["filled"]:
        told.append(f"{n} bubble{'' if n == 1 else 's'} of its gaps filled ({crumbs['filled_volume']:.2g} mm3)")
    if n := crumbs["slivers"]:
        below = f"less than {SLIVER * voxel:.2g} mm across"
        told.append(
            f"{n} sliver{'' if n == 1 else 's'} of the part, {below}, left out ({crumbs['slivers_volume']:.2g} mm3)"
        )
    if n := crumbs["unknown"]:
        told.append(f"{n} piece{'' if n == 1 else 's'} not looked at more closely")
    return "; ".join(told)
