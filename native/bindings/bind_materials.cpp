// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/arrays.hpp"
#include "bindings/bind.hpp"
#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "shading/lobes/lobe_models.hpp"
#include "shading/surface_program.hpp"
#include "volume/medium.hpp"
#include <map>
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;

static SurfaceOp make_op(int code, std::uint16_t out, std::uint16_t a, std::uint16_t b, std::uint16_t c,
                         std::uint16_t d, std::uint16_t e, std::uint16_t f, std::uint8_t option, std::uint8_t selector,
                         std::uint16_t texture, std::uint16_t uv_map, std::uint16_t table, std::uint8_t shift,
                         const Triple& value, const std::array<float, 9>& uv_matrix) {
    return {.code = static_cast<SurfaceOp::Code>(code),
            .option = option,
            .selector = selector,
            .out = out,
            .a = a,
            .b = b,
            .c = c,
            .d = d,
            .e = e,
            .f = f,
            .texture = texture,
            .texture_uv = uv_map,
            .table = table,
            .shift = shift,
            .value = to_vec3(value),
            .uv_matrix = to_matrix<mat3, 3>(uv_matrix.data())};
}

static GlossLayers make_gloss(const std::array<Triple, 4>& constant, const std::array<std::uint16_t, 4>& registers,
                              float mirror_ior, float coat_ior) {
    return {.constant = {.facing = to_vec3(constant[0]),
                         .edge = to_vec3(constant[1]),
                         .coat = to_vec3(constant[2]),
                         .coated = to_vec3(constant[3])},
            .facing_register = registers[0],
            .edge_register = registers[1],
            .coat_register = registers[2],
            .coated_register = registers[3],
            .mirror_ior = mirror_ior,
            .coat_ior = coat_ior};
}

static std::shared_ptr<FilmSpectra> make_film(const py::array& seen, float reach_nm, float fades_below_nm,
                                              bool covers_metals) {
    const std::vector<std::array<float, 6>> rows = to_vector<std::array<float, 6>, float>(seen, {-1, 6}, "seen");
    auto film = std::make_shared<FilmSpectra>();
    film->reach_nm = reach_nm;
    film->fades_below_nm = fades_below_nm;
    film->covers_metals = covers_metals;
    for (const std::array<float, 6>& row : rows) {
        film->cosine.emplace_back(row[0], row[1], row[2]);
        film->sine.emplace_back(row[3], row[4], row[5]);
    }
    validate(*film);
    return film;
}

static LobeSource make_lobes(int model, bool preserves_energy, const std::vector<Triple>& constants,
                             const std::vector<int>& registers, const std::array<int, 3>& normals, int bump_shadowing,
                             int subsurface, int distribution, int tangent, bool turns_smooth_normals,
                             const std::optional<std::shared_ptr<FilmSpectra>>& film) {
    const auto register_of = [](int index) {
        return index < 0 ? LobeSource::no_register : static_cast<std::uint16_t>(index);
    };
    LobeSource source{.model = static_cast<LobeModel>(model),
                      .preserves_energy = preserves_energy,
                      .subsurface = static_cast<SubsurfaceMethod>(subsurface),
                      .distribution = static_cast<FacetDistribution>(distribution),
                      .diffuse_normal = register_of(normals[0]),
                      .facet_normal = register_of(normals[1]),
                      .coat_normal = register_of(normals[2]),
                      .tangent = register_of(tangent),
                      .turns_smooth_normals = turns_smooth_normals,
                      .bump_shadowing = static_cast<BumpShadowing>(bump_shadowing),
                      .film = film.value_or(nullptr)};
    for (const Triple& constant : constants)
        source.constants.push_back(to_vec3(constant));
    for (const int index : registers)
        source.registers.push_back(register_of(index));
    return source;
}

static Material make_material(std::string name, bool has_surface, const Triple& diffuse, const Triple& transparent,
                              const Triple& emission, std::vector<SurfaceOp> program, std::uint16_t diffuse_register,
                              std::uint16_t transparent_register, std::uint16_t emission_register, float held_out,
                              std::optional<std::uint16_t> held_out_register,
                              const std::vector<std::shared_ptr<Texture>>& textures, std::vector<std::string> uv_maps,
                              const std::vector<py::array>& tables, std::optional<GlossLayers> gloss,
                              std::vector<LobeSource> lobes, std::int32_t medium) {
    Material material;
    material.name = std::move(name);
    material.program = std::move(program);
    material.diffuse_register = diffuse_register;
    material.transparent_register = transparent_register;
    material.emission_register = emission_register;
    material.held_out_register = held_out_register;
    material.constant = {.diffuse_albedo = to_vec3(diffuse),
                         .transparent = to_vec3(transparent),
                         .emission = to_vec3(emission),
                         .held_out = held_out};
    material.textures.assign(textures.begin(), textures.end());
    material.uv_map_names = std::move(uv_maps);
    for (const py::array& table : tables)
        material.tables.push_back({to_vector<vec4, float>(table, {-1, 4}, "tables")});
    material.gloss = gloss;
    material.lobe_sources = std::move(lobes);
    material.medium_index = medium;
    material.has_surface = has_surface;
    validate(material);
    return material;
}

static py::array_t<float> run_material(const Material& material, std::uint16_t result,
                                       const std::map<std::uint16_t, py::array>& answers, std::size_t count) {
    require(result < surface_register_count, "register ", result, " of ", surface_register_count);
    std::vector<Answer> all;
    for (const auto& [place, array] : answers) {
        check_array<float>(array, {static_cast<py::ssize_t>(count), 3}, "answers");
        all.push_back({place, {static_cast<const Rgb*>(array.data()), count}});
    }
    std::vector<float> values(3 * count);
    const std::span<Rgb> points(reinterpret_cast<Rgb*>(values.data()), count);
    {
        const py::gil_scoped_release release;
        constexpr std::size_t block = 4096;
        parallel_for((count + block - 1) / block, Progress(),
                     [&](std::size_t index) {
                         const std::size_t first = index * block, length = std::min(block, count - first);
                         std::vector<Answer> of_block = all;
                         for (Answer& answer : of_block)
                             answer.values = answer.values.subspan(first, length);
                         run_on_answers(material, result, of_block, points.subspan(first, length));
                     },
                     1);
    }
    return to_numpy(std::move(values), {static_cast<py::ssize_t>(count), 3});
}

static Medium make_medium(std::string name, const std::vector<std::tuple<Triple, float, float>>& lobes,
                          const Triple& sigma_a_per_m, const Triple& emission_w_per_m3_sr, std::uint8_t receiver_set) {
    Medium medium{.name = std::move(name),
                  .lobes = {},
                  .sigma_a_per_m = to_vec3(sigma_a_per_m),
                  .emission_w_per_m3_sr = to_vec3(emission_w_per_m3_sr),
                  .receiver_set = receiver_set};
    for (const auto& [sigma_s_per_m, asymmetry_g, draine_alpha] : lobes)
        medium.lobes.push_back(
            {.sigma_s_per_m = to_vec3(sigma_s_per_m), .asymmetry_g = asymmetry_g, .draine_alpha = draine_alpha});
    return medium;
}

void bind_materials(py::module_& native) {
    py::class_<SurfaceOp>(native, "SurfaceOp")
        .def(py::init(&make_op), "code"_a, "out"_a, "a"_a, "b"_a, "c"_a, "d"_a, "e"_a, "f"_a, "option"_a, "selector"_a,
             "texture"_a, "uv_map"_a, "table"_a, "shift"_a, "value"_a, "uv_matrix"_a);
    native.def(
        "operation_facts",
        [](const SurfaceOp& op) {
            const std::optional<OpFacts> facts = facts_of(op);
            require(facts.has_value(), "operation ", static_cast<int>(op.code), " is not known");
            return std::pair(static_cast<int>(facts->operand_count), (facts->reads & ~OpReads::table) == 0);
        },
        "op"_a, "How many registers it reads, and whether it reads nothing else, but a table. Raises InvalidInput.");
    py::class_<GlossLayers>(native, "Gloss")
        .def(py::init(&make_gloss), "constant"_a, "registers"_a, "mirror_ior"_a, "coat_ior"_a,
             "Four colours, and four registers: facing, edge, coat, coated.");
    py::class_<FilmSpectra, std::shared_ptr<FilmSpectra>>(native, "FilmSpectra")
        .def(py::init(&make_film), "seen"_a, "reach_nm"_a, "fades_below_nm"_a, "covers_metals"_a,
             "float32 (n, 6): the cosine's red, green and blue, then the sine's. Raises InvalidInput.");
    py::class_<LobeSource>(native, "Lobes")
        .def(py::init(&make_lobes), "model"_a, "preserves_energy"_a, "constants"_a, "registers"_a, "normals"_a,
             "bump_shadowing"_a, "subsurface"_a, "distribution"_a, "tangent"_a, "turns_smooth_normals"_a, "film"_a,
             "Of one shader: its inputs, each a colour, or, where it is not below 0, a register; three registers of "
             "normals, below 0 the point's own: of what is diffuse, of facets, of a coat; and that of the facets' "
             "tangent, below 0: none.");
    py::class_<Material>(native, "Material")
        .def(py::init(&make_material), "name"_a, "has_surface"_a, "diffuse"_a, "transparent"_a, "emission"_a,
             "program"_a, "diffuse_register"_a, "transparent_register"_a, "emission_register"_a, "held_out"_a,
             "held_out_register"_a, "textures"_a, "uv_maps"_a, "tables"_a, "gloss"_a, "lobes"_a, "medium"_a,
             "Raises InvalidInput, naming the material, for a program that cannot run.");
    native.def("run_on_answers", &run_material, "material"_a, "result"_a, "answers"_a, "count"_a,
               R"(What a register holds in the end at each of `count` points, float32 (count, 3). Releases the GIL.

answers: by place in the program, float32 (count, 3): what operations read beside operands and tables. Raises
InvalidInput where one is missing.)");
    py::class_<Medium>(native, "Medium")
        .def(py::init(&make_medium), "name"_a, "lobes"_a, "sigma_a_per_m"_a, "emission_w_per_m3_sr"_a,
             "receiver_set"_a = 0, "lobes: triples of sigma_s_per_m, asymmetry_g and draine_alpha.");
}
} // namespace tyndall::bindings
