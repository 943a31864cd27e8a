// From the mesh as it was read and judged to the mesh as a pass wants it: with marks that say what
// must stay.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "driver/steering.h"
#include "io/mesh_source.h"
#include "mesh/inspect.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// The cell arrays whose interfaces are kept: the named ones, or by default the integer arrays of
// one component named like materials (material, region, physical, tissue, block, zone, part,
// label); a partition's rank is none. Throws Error(kUsage) for a name that is no integer cell
// array.
std::vector<std::size_t> choose_regions(const MeshDescription& mesh,
                                        const std::optional<std::vector<std::string>>& names);

// One byte a point: 1 where tetrahedra of different regions meet.
Vector<std::uint8_t> find_interfaces(const std::vector<std::size_t>& regions,
                                     const Geometry& geometry, MeshSource* source);

// Moves the geometry's points and tetrahedra into a work mesh whose ids are the geometry's. A
// vertex is locked where `inspection` found it broken or carried, where a steering value is no
// number, and where `interfaces` (may be empty) says so. `steering` gives up its values.
template <class Real>
WorkMesh<Real> make_work_mesh(const Inspection& inspection,
                              std::span<const std::uint8_t> interfaces, Steering* steering,
                              Geometry* geometry);

}  // namespace tetfusion
