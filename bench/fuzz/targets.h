// What is fuzzed. A target takes any bytes and returns, or throws what nobody expects: then it has
// found something, as when a sanitizer ends the process.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tetfusion::fuzz {

using Input = std::span<const std::uint8_t>;

struct Target {
  std::string_view name;
  void (*run)(Input);
  std::vector<std::string> (*seeds)();
};

// Readers: bytes are a file. The length's last two bits say how it is read (bit 0: tetrahedralize,
// bit 1: linearize), so that a seed is a file as any other.
void read_vtu(Input);
void read_legacy(Input);
void read_medit(Input);
void read_gmsh(Input);
// Several files, parted by kCut: NAME.node, .ele, .face, .edge; NAME.pvtu and its
// pieces "0.vtu", "1.vtu", ...
inline constexpr std::string_view kCut = "\n%%%%\n";
void read_tetgen(Input);
void read_pvtu(Input);

// The list of a series' files, which are not opened.
void read_pvd_list(Input);

// A section file, a manifest or the state of a checkpoint, by what they begin with. Each is taken
// as it is, and again with its checksums put right.
void read_chunk_store(Input);

// A map, and what follows it; again with its checksums put right.
void read_map(Input);

// A progressive file, refined; again with its checksums put right. What does not begin as one says
// which bytes of one, before it is deflated, are to be changed: five bytes each, the section's
// number, three of a place, and what is different there.
void read_progressive(Input);

// Arguments, one a line. The command runs as it does for users, but that no file can be opened.
void run_command(Input);

std::span<const Target> targets();
// nullptr: there is none of this name.
const Target* find_target(std::string_view name);

std::vector<std::string> vtk_seeds();  // as VTK's own writer has them
std::vector<std::string> vtu_seeds();  // those, and what else may be in a file
std::vector<std::string> pvtu_seeds();
std::vector<std::string> pvd_seeds();
std::vector<std::string> legacy_seeds();
std::vector<std::string> medit_seeds();
std::vector<std::string> gmsh_seeds();
std::vector<std::string> tetgen_seeds();
std::vector<std::string> chunk_store_seeds();
std::vector<std::string> map_seeds();
std::vector<std::string> progressive_seeds();
std::vector<std::string> command_seeds();

}  // namespace tetfusion::fuzz
