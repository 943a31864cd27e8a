#include "library/owned_sink.h"

#include <algorithm>

#include "library/requests.h"

namespace tetfusion {

namespace {

std::byte* bytes(OwnedValues* values) { return static_cast<std::byte*>(values->data()); }

std::vector<OwnedArray> make_arrays(const AttributeSet& set, std::uint64_t tuples,
                                    std::vector<std::byte*>* room) {
  std::vector<OwnedArray> arrays;
  for (const ArrayInfo& info : set.arrays) {
    arrays.push_back(
        {info.name, info.components, OwnedValues(to_type(info.type), tuples * info.components)});
    room->push_back(bytes(&arrays.back().values));
  }
  return arrays;
}

}  // namespace

MeshRoom OwnedSink::make_room(const MeshLayout& layout) {
  MeshRoom room;
  // Numbers of points always fit, as those of the input did.
  const ValueType input_ids = to_value_type(id_type_);
  room.id_type = tets_only_ ? input_ids : id_type_for(layout, input_ids);
  const Type ids = to_type(room.id_type);
  mesh_.tets = layout.tets;
  mesh_.points = OwnedValues(to_type(layout.point_type), 3 * layout.points);
  mesh_.connectivity = OwnedValues(ids, layout.corners);
  if (!tets_only_) {
    mesh_.offsets = OwnedValues(ids, layout.cells + 1);
    mesh_.types = OwnedValues(Type::kUInt8, layout.cells);
  }
  room.points = bytes(&mesh_.points);
  room.connectivity = bytes(&mesh_.connectivity);
  room.offsets = bytes(&mesh_.offsets);
  room.types = static_cast<std::uint8_t*>(mesh_.types.data());
  mesh_.point_arrays = make_arrays(layout.point_data, layout.points, &room.point_arrays);
  mesh_.cell_arrays = make_arrays(layout.cell_data, layout.cells, &room.cell_arrays);
  return room;
}

}  // namespace tetfusion
