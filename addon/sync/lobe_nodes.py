# SPDX-License-Identifier: GPL-3.0-or-later
"""Surface shaders that are more than a diffuse share, as lobes: see native/shading/lobes/lobe_source.hpp."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from tyndall.scene_description import BumpShadowing, LobeModel, SubsurfaceMethod

from .bent_nodes import add_bent_glass, through_one_side
from .facet_nodes import facets_of_glass, facets_of_glossy, facets_of_metal
from .film_nodes import film_of
from .hair_nodes import hair_bsdf, principled_hair
from .lobe_values import Facets, Film, LobeNormals, LobeValues
from .math_nodes import vector_operation
from .program import BLACK, WHITE, Program, Term, Value, grey
from .subsurface_nodes import method_of, principled_inputs, principled_share, scattering_inputs

if TYPE_CHECKING:
    from collections.abc import Callable

    from .node_graph import Socket
    from .surface_nodes import Shares
    from .value_nodes import ValueReader

_GREY = grey(0.8)
_SHARP = 0.05  #: Roughness.


def add_lobes(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> bool:
    """Whether the shader is one of those; then what it does is added to the shares."""
    read = _SHADERS.get(at.node.type)
    return read is not None and read(reader, at, weight, shares)


def plain_principled() -> LobeValues:
    """The Principled BSDF as it is when it is added: what has no material, from 5.0 on."""
    specular, ior, coat_roughness = grey(0.5), grey(1.5), grey(0.03)
    inputs = (WHITE, _GREY, BLACK, grey(0.5), specular, WHITE, BLACK, ior, BLACK, coat_roughness, grey(1.5), WHITE)
    return LobeValues(LobeModel.PRINCIPLED, (*inputs, BLACK, BLACK), preserves_energy=True)


def _positive(program: Program, value: Value) -> Value:
    return vector_operation(program, "MAXIMUM", value, BLACK)


def _is_old() -> bool:
    """Up to 3.x, shaders have other formulas."""
    return bool(bpy.app.version < (4, 0, 0))


def _push(
    shares: Shares,
    model: LobeModel,
    *inputs: Value,
    preserves_energy: bool = False,
    normals: LobeNormals | None = None,
    subsurface: SubsurfaceMethod = SubsurfaceMethod.NONE,
    facets: Facets | None = None,
    film: Film | None = None,
) -> bool:
    if shares.lobes is None:
        return False
    normals, facets = normals or LobeNormals(), facets or Facets()
    shares.lobes.append(LobeValues(model, inputs, preserves_energy, normals, subsurface, facets, film))
    return True


def _normals(reader: ValueReader, at: Socket) -> LobeNormals:
    """Of what is diffuse, and turned so that a mirror could have them, of facets."""
    shadowing = BumpShadowing.SMOOTH if _is_old() else BumpShadowing.FACETS
    normal, coat = at.input("Normal"), at.input("Coat Normal") or at.input("Clearcoat Normal")
    # What displacement bends is the surface's normal, not a bump of its closures: Cycles lets it shadow nothing.
    has_bump = reader.displaced_normal is None or (normal is not None and normal.is_connected())
    return LobeNormals(
        diffuse=reader.normal(normal),
        facets=reader.normal(normal, is_specular=True),
        coat=reader.normal(coat, is_specular=True),
        bump_shadowing=shadowing if reader.corrects_bumps and has_bump else BumpShadowing.NONE,
        turns_smooth_ones=reader.corrects_bumps,
    )


def _note_sharpness(reader: ValueReader, shares: Shares, roughness: Value) -> None:
    if shares.sharp is None and not isinstance(roughness, Term) and roughness[0] <= _SHARP:
        reader.note("what is as sharp as a mirror shows lamps and the world alone, as mirrors are not followed")


def _is_multiple(at: Socket) -> bool:
    return getattr(at.node, "distribution", "") in {"MULTI_GGX", "MULTIPLE"}


def _diffuse(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> bool:
    roughness, normals = reader.number(at.input("Roughness")), _normals(reader, at)
    colour = reader.colour(at.input("Color"), _GREY)
    if roughness == BLACK:
        return normals.diffuse is not None and _push(shares, LobeModel.LAMBERT, weight, colour, normals=normals)
    model = LobeModel.OREN_NAYAR_3 if _is_old() else LobeModel.OREN_NAYAR
    return _push(shares, model, weight, colour, roughness, normals=normals)


def _translucent(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> bool:
    if reader.normal(at.input("Normal")) is not None:
        reader.note("normal maps and bumps of translucent surfaces are not drawn")
    return _push(shares, LobeModel.TRANSLUCENT, weight, reader.colour(at.input("Color"), _GREY))


def _glossy(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> bool:
    is_sharp = getattr(at.node, "distribution", "") == "SHARP"
    model = LobeModel.GLOSSY_3 if _is_old() else LobeModel.GLOSSY
    roughness = BLACK if is_sharp else reader.number(at.input("Roughness"), 0.5)
    _note_sharpness(reader, shares, roughness)
    colour = reader.colour(at.input("Color"), _GREY)
    normals, facets = _normals(reader, at), facets_of_glossy(reader, at)
    inputs = weight, colour, roughness
    return _push(shares, model, *inputs, preserves_energy=_is_multiple(at), normals=normals, facets=facets)


def _metallic(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> bool:
    roughness = reader.number(at.input("Roughness"), 0.5)
    _note_sharpness(reader, shares, roughness)
    if getattr(at.node, "fresnel_type", "F82") == "F82":
        model, names = LobeModel.METAL_F82, ("Base Color", "Edge Tint")
    else:
        model, names = LobeModel.CONDUCTOR, ("IOR", "Extinction")
    first, second = (reader.colour(at.input(name), WHITE) for name in names)
    return _push(
        shares,
        model,
        weight,
        first,
        roughness,
        second,
        preserves_energy=_is_multiple(at),
        normals=_normals(reader, at),
        facets=facets_of_metal(reader, at),
        film=film_of(reader, at),
    )


def _pass_straight(reader: ValueReader, shares: Shares, passing: Value, base: Value) -> None:
    """What a Principled BSDF transmits."""
    reader.note("transmission is drawn as transparent in its colour, with its reflections")
    program = reader.program
    shares.has_glass = True
    coloured = program.multiply(passing, through_one_side(program, base))
    shares.transparent = program.add(shares.transparent, coloured)


def _glass(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> bool:
    if add_bent_glass(reader, at, weight, shares):
        return True
    reader.unsupported(at, "is drawn as transparent in its colour, with its reflections")
    shares.has_glass = True
    program = reader.program
    colour = reader.colour(at.input("Color"), WHITE)
    shares.transparent = program.add(shares.transparent, program.multiply(weight, colour))
    is_sharp = getattr(at.node, "distribution", "") == "SHARP"
    model = LobeModel.GLASS_3 if _is_old() else LobeModel.GLASS
    roughness = BLACK if is_sharp else reader.number(at.input("Roughness"))
    inputs = weight, colour, roughness, reader.number(at.input("IOR"), 1.45)
    return _push(
        shares,
        model,
        *inputs,
        preserves_energy=_is_multiple(at),
        normals=_normals(reader, at),
        facets=facets_of_glass(at),
        film=film_of(reader, at),
    )


def _sheen(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> bool:
    """From 4.0 on; its older distribution is what was called velvet."""
    if getattr(at.node, "distribution", "ASHIKHMIN") == "ASHIKHMIN":
        return _velvet(reader, at, weight, shares)
    roughness, colour = reader.number(at.input("Roughness"), 0.5), reader.colour(at.input("Color"), _GREY)
    return _push(shares, LobeModel.SHEEN, weight, colour, roughness, normals=_normals(reader, at))


def _velvet(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> bool:
    sigma = reader.number(at.input("Sigma") or at.input("Roughness"), 1.0)
    colour = reader.colour(at.input("Color"), _GREY)
    return _push(shares, LobeModel.VELVET, weight, colour, sigma, normals=_normals(reader, at))


def _toon(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> bool:
    model = LobeModel.GLOSSY_TOON if getattr(at.node, "component", "") == "GLOSSY" else LobeModel.DIFFUSE_TOON
    size, smooth = (reader.number(at.input(name)) for name in ("Size", "Smooth"))
    colour = reader.colour(at.input("Color"), _GREY)
    return _push(shares, model, weight, colour, size, smooth, normals=_normals(reader, at))


def _subsurface(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> bool:
    inputs, normals = scattering_inputs(reader, at), _normals(reader, at)
    return _push(shares, LobeModel.SUBSURFACE, weight, *inputs, normals=normals, subsurface=method_of(at))


def _principled(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> bool:
    program = reader.program
    specular = reader.number(at.input("Specular IOR Level") or at.input("Specular"), 0.5)
    metallic, roughness = reader.number(at.input("Metallic")), reader.number(at.input("Roughness"), 0.5)
    transmission = reader.number(at.input("Transmission Weight") or at.input("Transmission"))
    coat = reader.number(at.input("Coat Weight") or at.input("Clearcoat"))
    sheen = reader.number(at.input("Sheen Weight") or at.input("Sheen"))
    diffuse_roughness = reader.number(at.input("Diffuse Roughness"))
    subsurface, normals = principled_share(reader, at), _normals(reader, at)
    film = film_of(reader, at)
    rough = specular, metallic, transmission, coat, sheen, diffuse_roughness, subsurface
    if not _is_old() and film is None and normals.diffuse is None and all(value == BLACK for value in rough):
        return False
    alpha = program.clamp(reader.number(at.input("Alpha"), 1.0))
    shares.transparent = program.add(shares.transparent, program.multiply(weight, program.complement(alpha)))
    weight = program.multiply(weight, alpha)

    emission = at.input("Emission Color") or at.input("Emission")  # renamed in 4.0
    radiance = program.multiply(reader.colour(emission), reader.number(at.input("Emission Strength"), 1.0))
    if _is_old() or coat == sheen == BLACK:  # else it shines through these
        shares.emission = program.add(shares.emission, program.multiply(weight, radiance))
        radiance = BLACK

    _note_sharpness(reader, shares, roughness)
    base = reader.colour(at.input("Base Color"), _GREY)
    if transmission != BLACK:
        passing = program.multiply(program.clamp(transmission), program.complement(program.clamp(metallic)))
        _pass_straight(reader, shares, program.multiply(weight, passing), base)
    coat_roughness = reader.number(at.input("Coat Roughness") or at.input("Clearcoat Roughness"), 0.03)
    ior, is_multiple = reader.number(at.input("IOR"), 1.45), _is_multiple(at)
    if _is_old():
        tint, sheen_tint = (reader.number(at.input(name)) for name in ("Specular Tint", "Sheen Tint"))
        inputs = [specular, tint, sheen, sheen_tint, coat, coat_roughness, transmission, ior]
        model = LobeModel.PRINCIPLED_3 if subsurface == BLACK else LobeModel.PRINCIPLED_3_SUBSURFACE
    else:
        coat_ior, coat_tint = reader.number(at.input("Coat IOR"), 1.5), reader.colour(at.input("Coat Tint"), WHITE)
        tint = reader.colour(at.input("Specular Tint"), WHITE)
        inputs = [specular, tint, transmission, ior, coat, coat_roughness, coat_ior, coat_tint]
        inputs += [diffuse_roughness, radiance]
        model = LobeModel.PRINCIPLED
        if sheen != BLACK or subsurface != BLACK:
            sheen_tint = reader.colour(at.input("Sheen Tint"), WHITE)
            inputs += [program.multiply(_positive(program, sheen), _positive(program, sheen_tint))]
            inputs += [reader.number(at.input("Sheen Roughness"), 0.5)]
            model = LobeModel.PRINCIPLED_SHEEN if subsurface == BLACK else LobeModel.PRINCIPLED_SUBSURFACE
    inputs = [weight, base, metallic, roughness, *inputs]
    method = SubsurfaceMethod.NONE
    if subsurface != BLACK:
        inputs += principled_inputs(reader, at, base, subsurface)
        method = method_of(at)
    return _push(
        shares,
        model,
        *inputs,
        preserves_energy=is_multiple,
        normals=normals,
        subsurface=method,
        facets=facets_of_metal(reader, at),
        film=film,
    )


def _of_fibre(reader: ValueReader, at: Socket, weight: Value, shares: Shares) -> bool:
    if shares.lobes is None:
        return False
    shares.lobes.append((hair_bsdf if at.node.type == "BSDF_HAIR" else principled_hair)(reader, at, weight))
    return True


_SHADERS: dict[str, Callable[[ValueReader, Socket, Value, Shares], bool]] = {
    "BSDF_DIFFUSE": _diffuse,
    "BSDF_TRANSLUCENT": _translucent,
    "BSDF_GLOSSY": _glossy,
    "BSDF_ANISOTROPIC": _glossy,
    "BSDF_METALLIC": _metallic,
    "BSDF_GLASS": _glass,
    "BSDF_REFRACTION": add_bent_glass,
    "BSDF_VELVET": _velvet,
    "BSDF_SHEEN": _sheen,
    "BSDF_TOON": _toon,
    "BSDF_PRINCIPLED": _principled,
    "SUBSURFACE_SCATTERING": _subsurface,
    "BSDF_HAIR": _of_fibre,
    "BSDF_HAIR_PRINCIPLED": _of_fibre,
}
