// A progressive file, refined to the original, to levels on the way, and in a region.
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/run_context.h"
#include "driver/simplify.h"
#include "fuzz/targets.h"
#include "io/files/checksum.h"
#include "io/progressive/packed_columns.h"
#include "refine/refine.h"
#include "support/mesh_file.h"
#include "support/temp_dir.h"
#include "support/vtu_text.h"

namespace tetfusion::fuzz {

namespace {

// io/FORMAT.md.
constexpr std::size_t kHeaderBytes = 112, kTableRow = 48;
constexpr std::size_t kLengthAt = 16, kTableAt = 24, kSectionsAt = 32, kTableSumAt = 40,
                      kHeaderSumAt = 104;

const testing::TempDir& folder() {
  static const testing::TempDir dir = testing::TempDir::in_memory();
  return dir;
}

std::uint64_t number_at(const std::string& bytes, std::size_t at) {
  std::uint64_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

void put(std::string* bytes, std::size_t at, std::uint64_t value) {
  std::memcpy(bytes->data() + at, &value, sizeof value);
}

std::uint64_t sum_of(const std::string& bytes, std::size_t from, std::size_t count) {
  return checksum(std::as_bytes(std::span(bytes).subspan(from, count)));
}

// Puts the checksums right, and the length.
void seal(std::string* bytes) {
  if (bytes->size() < kHeaderBytes) return;
  const std::uint64_t table = number_at(*bytes, kTableAt), rows = number_at(*bytes, kSectionsAt);
  if (table > bytes->size() || rows != (bytes->size() - table) / kTableRow) return;
  for (std::uint64_t i = 0; i < rows; ++i) {
    const std::size_t row = table + i * kTableRow;
    const std::uint64_t offset = number_at(*bytes, row), count = number_at(*bytes, row + 8);
    if (offset > bytes->size() || count > bytes->size() - offset) continue;
    put(bytes, row + 24, sum_of(*bytes, offset, count));
  }
  put(bytes, kLengthAt, bytes->size());
  put(bytes, kTableSumAt, sum_of(*bytes, table, bytes->size() - table));
  put(bytes, kHeaderSumAt, sum_of(*bytes, 0, kHeaderSumAt));
}

// The same file with its sections inflated, changed where the input says so, and deflated again:
// what is mutated as it is does not inflate.
std::string repacked(const std::string& bytes, Input changes) {
  if (bytes.size() < kHeaderBytes) return bytes;
  const std::uint64_t table = number_at(bytes, kTableAt), rows = number_at(bytes, kSectionsAt);
  if (table > bytes.size() || rows > (bytes.size() - table) / kTableRow) return bytes;
  std::string out = bytes.substr(0, kHeaderBytes), rows_out;
  for (std::uint64_t i = 0; i < rows; ++i) {
    std::string row = bytes.substr(table + i * kTableRow, kTableRow);
    const std::uint64_t offset = number_at(row, 0), count = number_at(row, 8);
    if (offset > table || count > table - offset) return bytes;
    Vector<std::byte> raw =
        inflated(std::as_bytes(std::span(bytes).subspan(offset, count)), number_at(row, 16));
    for (std::size_t c = 0; c + 4 < changes.size() && !raw.empty(); c += 5) {
      if (changes[c] % rows != i) continue;
      std::uint32_t at = 0;
      std::memcpy(&at, changes.data() + c + 1, 3);
      raw[at % raw.size()] ^= static_cast<std::byte>(changes[c + 4]);
    }
    const Vector<std::byte> packed = deflated(raw);
    put(&row, 0, out.size());
    put(&row, 8, packed.size());
    out.append(reinterpret_cast<const char*>(packed.data()), packed.size());
    rows_out += row;
  }
  put(&out, kTableAt, out.size());
  out += rows_out;
  seal(&out);
  return out;
}

void refine_one(const std::string& bytes) {
  const std::string path = folder().file("input.tfp");
  testing::write_file(path, bytes);
  RefineRequest request;
  request.input = path;
  request.output = folder().file("out.vtu");
  const auto run = [&](const auto& change) {
    RefineRequest changed = request;
    change(&changed);
    try {
      refine(changed);
    } catch (const Error&) {
    }
  };
  run([](RefineRequest*) {});
  run([](RefineRequest* r) { r->tets = 40; });
  run([](RefineRequest* r) { r->max_rms = 0.01; });
  run([](RefineRequest* r) { r->region = {"sphere=0,0,0,1.1"}; });
}

std::string file_of(Method method, std::uint64_t chunk_tets) {
  testing::rich_box(3).write(folder().file("in.vtu"));
  SimplifyRequest request;
  request.input = folder().file("in.vtu");
  request.output = folder().file("out.vtu");
  request.progressive = folder().file("seed.tfp");
  request.behaviour.method = method;
  request.behaviour.chunk_tets = chunk_tets;
  request.behaviour.reduction = 0.8;
  request.performance.threads = 1;
  simplify(request);
  return testing::bytes_of(request.progressive);
}

const std::string& seed() {
  static const std::string bytes = file_of(Method::kFuse, 200'000);
  return bytes;
}

}  // namespace

// A file, as it is and with its checksums put right; or changes to one that is whole.
void read_progressive(Input input) {
  std::string bytes(input.begin(), input.end());
  if (bytes.starts_with("TFPROGRS")) {
    refine_one(bytes);
    seal(&bytes);
    refine_one(bytes);
  } else {
    refine_one(repacked(seed(), input));
  }
}

std::vector<std::string> progressive_seeds() {
  return {file_of(Method::kFuse, 200'000), file_of(Method::kFuse, 60),
          file_of(Method::kTetFuse, 200'000), std::string(25, '\3')};
}

}  // namespace tetfusion::fuzz
