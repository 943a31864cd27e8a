#include "driver/checkpoint.h"

#include <algorithm>
#include <type_traits>

namespace tetfusion {

namespace {

// One list of fields for all: `stream` is one of these.
struct Putting {
  ByteWriter* writer;
  template <class T>
  void value(const T& v) {
    writer->put(v);
  }
  template <class T>
  void all(const T& v) {
    writer->put_all(v);
  }
};

// How many bytes that takes.
struct Counting {
  std::size_t* bytes;
  template <class T>
  void value(const T& v) {
    *bytes += sizeof v;
  }
  template <class T>
  void all(const T& v) {
    *bytes += sizeof(std::uint64_t) + v.size() * sizeof(typename T::value_type);
  }
};

struct Getting {
  ByteReader* reader;
  template <class T>
  void value(T& v) {
    reader->get(&v);
  }
  template <class T>
  void all(T& v) {
    reader->get_all(&v);
  }
};

// Grows a list that is read one by one: its size is not to be trusted before its elements are
// there.
template <class Stream, class List, class PassOne>
void pass_list(Stream stream, List& list, PassOne pass_one) {
  std::uint64_t size = list.size();
  stream.value(size);
  if constexpr (!std::is_const_v<List>) list.clear();
  for (std::uint64_t i = 0; i < size; ++i) {
    if constexpr (!std::is_const_v<List>) list.emplace_back();
    pass_one(list[i]);
  }
}

template <class Stream, class Strings>
void pass_strings(Stream stream, Strings& strings) {
  pass_list(stream, strings, [&](auto& s) { stream.all(s); });
}

template <class Stream, class Bits>
void pass_bits(Stream stream, Bits& bits) {
  std::uint64_t size = bits.size();
  stream.value(size);
  Vector<std::uint8_t> bytes;
  if constexpr (std::is_const_v<Bits>) {
    bytes.assign((size + 7) / 8, 0);
    for (std::uint64_t i = 0; i < size; ++i) {
      bytes[i / 8] |= static_cast<std::uint8_t>((bits[i] ? 1 : 0) << i % 8);
    }
  }
  stream.all(bytes);
  if constexpr (!std::is_const_v<Bits>) {
    bits.resize(std::min<std::uint64_t>(size, 8 * bytes.size()));
    for (std::uint64_t i = 0; i < bits.size(); ++i) bits[i] = (bytes[i / 8] >> i % 8 & 1) != 0;
  }
}

template <class Stream, class Columns>
void pass_columns(Stream stream, Columns& columns) {
  pass_list(stream, columns, [&](auto& c) {
    stream.value(c.type);
    stream.value(c.components);
    stream.all(c.rows);
  });
}

template <class Stream, class State>
void pass(Stream stream, State& state) {
  auto& mesh = state.mesh;
  stream.value(mesh.tets);
  stream.value(mesh.removed);
  stream.value(mesh.chunks);
  auto curve = mesh.cut.curve();
  auto first_keys = mesh.cut.first_keys();
  stream.value(curve);
  stream.all(first_keys);
  if constexpr (!std::is_const_v<State>) mesh.cut = CurveCut(curve, std::move(first_keys));
  stream.all(mesh.interface.entries());
  stream.all(mesh.sizes);
  stream.all(mesh.costs);
  stream.all(mesh.locks);
  stream.all(mesh.samples);
  stream.value(mesh.facing.box());
  stream.all(mesh.facing.cells());
  stream.value(state.input.box);
  pass_bits(stream, state.input.rewound);
  stream.value(state.input.facts);
  auto& lower = state.input.lower;
  stream.all(lower.cells.types);
  stream.all(lower.cells.offsets);
  stream.all(lower.cells.connectivity);
  pass_columns(stream, lower.columns);
  stream.all(lower.numbers);
  stream.all(lower.vertices);
  stream.all(lower.loose_ids);
  stream.all(lower.loose_positions);
  pass_columns(stream, lower.loose_columns);
  stream.all(state.fields);
  pass_strings(stream, state.field_names);
  stream.value(state.steering_width);
  stream.all(state.rounds);
  pass_list(stream, state.outputs, [&](auto& output) {
    stream.all(output.path);
    stream.value(output.points);
    stream.value(output.tets);
    stream.value(output.boundary_triangles);
    stream.value(output.volume);
  });
  stream.all(state.log_slices);
  stream.value(state.kept_values.chunks);
  stream.all(state.kept_values.fractions);
  stream.value(state.chunk_tets);
  stream.value(state.shrink);
  stream.value(state.spread);
  stream.value(state.costs);
  stream.value(state.threshold);
  stream.value(state.weights.scale);
  stream.value(state.weights.mean);
  stream.value(state.end);
}

}  // namespace

template <class Real>
Vector<std::byte> save(const RunState<Real>& state) {
  std::size_t bytes = 0;
  pass(Counting{&bytes}, state);
  ByteWriter writer(bytes);
  pass(Putting{&writer}, state);
  return writer.take();
}

template <class Real>
void load(std::span<const std::byte> bytes, RunState<Real>* state) {
  ByteReader reader(bytes);
  pass(Getting{&reader}, *state);
  state->mesh.interface.index();
}

template Vector<std::byte> save(const RunState<float>&);
template Vector<std::byte> save(const RunState<double>&);
template void load(std::span<const std::byte>, RunState<float>*);
template void load(std::span<const std::byte>, RunState<double>*);

}  // namespace tetfusion
