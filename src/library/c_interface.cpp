#include <fmt/format.h>

#include <new>
#include <string>
#include <vector>

#include "base/error.h"
#include "library/options_text.h"
#include "tetfusion.h"
#include "tetfusion_c.h"

namespace tf = tetfusion;

struct tetfusion_result {
  tf::Result result;
  std::vector<tetfusion_array> point_arrays, cell_arrays;  // of the mesh
  std::string active_scalars;
  tetfusion_mesh mesh{};
};

namespace {

static_assert(TETFUSION_INT8 == static_cast<int>(tf::Type::kInt8) &&
              TETFUSION_UINT8 == static_cast<int>(tf::Type::kUInt8) &&
              TETFUSION_FLOAT64 == static_cast<int>(tf::Type::kFloat64));

std::string text_of(const char* text) { return text == nullptr ? "" : text; }

tf::Values to_values(const tetfusion_values& values, const std::string& what) {
  if (values.type < TETFUSION_INT8 || values.type > TETFUSION_FLOAT64) {
    throw tf::Error(tf::ErrorCode::kUsage,
                    fmt::format("the mesh: {}: there is no type {}", what, values.type));
  }
  return {static_cast<tf::Type>(values.type), values.data, values.size};
}

std::span<const std::uint8_t> to_bytes(const tetfusion_values& values, const char* what) {
  const tf::Values bytes = to_values(values, what);
  if (!bytes.empty() && bytes.type() != tf::Type::kUInt8) {
    throw tf::Error(tf::ErrorCode::kUsage, fmt::format("the mesh: {} must be of UInt8", what));
  }
  return {static_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

std::vector<tf::Array> to_arrays(const tetfusion_array* arrays, std::uint64_t count,
                                 const char* kind) {
  if (arrays == nullptr && count > 0) {
    throw tf::Error(
        tf::ErrorCode::kBadInput,
        fmt::format("the mesh: there are {} {} arrays, but their address is null", count, kind));
  }
  std::vector<tf::Array> out;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::string name = text_of(arrays[i].name);
    out.push_back({name, arrays[i].components,
                   to_values(arrays[i].values, fmt::format("{} array \"{}\"", kind, name))});
  }
  return out;
}

tf::Mesh to_mesh(const tetfusion_mesh& mesh) {
  tf::Mesh out;
  out.points = to_values(mesh.points, "points");
  out.connectivity = to_values(mesh.connectivity, "connectivity");
  out.offsets = to_values(mesh.offsets, "offsets");
  out.types = to_bytes(mesh.types, "types");
  out.ghosts = to_bytes(mesh.ghosts, "ghosts");
  out.point_arrays = to_arrays(mesh.point_arrays, mesh.point_array_count, "point");
  out.cell_arrays = to_arrays(mesh.cell_arrays, mesh.cell_array_count, "cell");
  out.active_scalars = text_of(mesh.active_scalars);
  return out;
}

tf::Observer to_observer(const tetfusion_observer* observer) {
  tf::Observer out;
  if (observer == nullptr) return out;
  if (observer->progress != nullptr) {
    out.progress = [=](double share, std::string_view phase) {
      observer->progress(observer->data, share, std::string(phase).c_str());
    };
  }
  if (observer->cancelled != nullptr) {
    out.cancelled = [=] { return observer->cancelled(observer->data) != 0; };
  }
  if (observer->notice != nullptr) {
    out.notice = [=](std::string_view sentence) {
      observer->notice(observer->data, std::string(sentence).c_str());
    };
  }
  return out;
}

tetfusion_values view_of(const tf::OwnedValues& values) {
  return {static_cast<std::int32_t>(values.type()), values.data(), values.size()};
}

std::vector<tetfusion_array> views_of(const std::vector<tf::OwnedArray>& arrays) {
  std::vector<tetfusion_array> out;
  for (const tf::OwnedArray& array : arrays) {
    out.push_back({array.name.c_str(), array.components, view_of(array.values)});
  }
  return out;
}

void show_mesh(const tetfusion_mesh& input, tetfusion_result* result) {
  const tf::OwnedMesh& mesh = result->result.mesh;
  result->active_scalars = text_of(input.active_scalars);
  if (!result->active_scalars.empty()) {
    result->mesh.active_scalars = result->active_scalars.c_str();
  }
  result->point_arrays = views_of(mesh.point_arrays);
  result->cell_arrays = views_of(mesh.cell_arrays);
  result->mesh.points = view_of(mesh.points);
  result->mesh.connectivity = view_of(mesh.connectivity);
  result->mesh.offsets = view_of(mesh.offsets);
  result->mesh.types = view_of(mesh.types);
  result->mesh.point_arrays = result->point_arrays.data();
  result->mesh.point_array_count = result->point_arrays.size();
  result->mesh.cell_arrays = result->cell_arrays.data();
  result->mesh.cell_array_count = result->cell_arrays.size();
}

}  // namespace

tetfusion_result* tetfusion_simplify(const tetfusion_mesh* mesh, const char* options,
                                     const tetfusion_observer* observer) {
  auto* out = new (std::nothrow) tetfusion_result;
  if (out == nullptr) return nullptr;
  const auto fail = [&](tf::Code code, const char* message) {
    out->result = {};
    out->result.status.code = code;
    try {
      out->result.status.message = message;
    } catch (const std::bad_alloc&) {  // then without
    }
  };
  try {
    if (mesh == nullptr) throw tf::Error(tf::ErrorCode::kUsage, "there is no mesh");
    out->result =
        tf::simplify(to_mesh(*mesh), tf::read_options(options == nullptr ? "{}" : options),
                     to_observer(observer));
    show_mesh(*mesh, out);
  } catch (const tf::Error& error) {
    fail(static_cast<tf::Code>(error.exit_code()), error.what());
  } catch (const std::exception& error) {  // there is nothing else than too little memory
    fail(tf::Code::kMemory, error.what());
  }
  return out;
}

std::int32_t tetfusion_code(const tetfusion_result* result) {
  return static_cast<std::int32_t>(result->result.status.code);
}

const char* tetfusion_message(const tetfusion_result* result) {
  return result->result.status.message.c_str();
}

const char* tetfusion_report(const tetfusion_result* result) {
  return result->result.report.json.c_str();
}

const tetfusion_mesh* tetfusion_mesh_of(const tetfusion_result* result) { return &result->mesh; }

void tetfusion_free(tetfusion_result* result) { delete result; }

const char* tetfusion_version() { return tf::library_version(); }
