// From the mesh as it was read to the mesh as a pass wants it: judged, marked, and in curve order.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "driver/steering.h"
#include "io/mesh_source.h"
#include "kernel/work_mesh.h"
#include "mesh/inspect.h"

namespace tetfusion {

// The cell arrays whose interfaces are kept: the named ones, or by default the integer arrays of one component
// named like materials (material, region, physical, tissue, block, zone, part, label); a partition's rank is
// none. Throws Error(kUsage) for a name that is no integer cell array.
std::vector<std::size_t> choose_regions(const MeshDescription& mesh,
                                        const std::optional<std::vector<std::string>>& names);

// One byte a point: 1 where tetrahedra of different regions meet.
Vector<std::uint8_t> find_interfaces(const std::vector<std::size_t>& regions, const Geometry& geometry,
                                     MeshSource* source);

// Builds the work mesh of the geometry's points and tetrahedra, both along the curve, and releases them. A vertex
// is locked where `inspection` found it broken or carried, where a steering value is no number, and where
// `interfaces` (may be empty) says so.
template <class Real>
WorkMesh<Real> make_work_mesh(const Inspection& inspection, const Steering& steering,
                              std::span<const std::uint8_t> interfaces, Geometry* geometry);

}  // namespace tetfusion
