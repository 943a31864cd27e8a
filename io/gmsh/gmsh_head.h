// What a Gmsh file (.msh 1, 2.0 to 2.2, 4.0 and 4.1) consists of, and where.
//
//   $MeshFormat                  version, 0: text, 1: binary, bytes of a real
//   2.2 0 8
//   $EndMeshFormat
//   $PhysicalNames ... $Entities ... $Nodes ... $Elements ... $NodeData ... $ElementData ...
//
// In a binary file the numbers within sections are binary; how long a section is then follows from
// the counts in it. Version 1 is text without a $MeshFormat: $NOD ... $ENDNOD and $ELM ... $ENDELM.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/formats/format_file.h"
#include "io/gmsh/gmsh_groups.h"

namespace tetfusion {

inline constexpr const char* kGmshPhysical = "gmsh:physical";
inline constexpr const char* kGmshGeometrical = "gmsh:geometrical";
// What is left out of a partitioned mesh.
inline constexpr const char* kGmshPartitions = "numbers of partitions";
// A name of physical groups, in the name of a field array: a row of tag and dimension for each.
inline constexpr const char* kGmshNamePrefix = "gmsh:physical:";

// Rows, between two places of a section that are kept in mind.
inline constexpr std::uint64_t kRowsPerPlace = 4096;

// Numbers of a section one after another, text or binary alike. Everything fails at the section's
// end, naming the place.
class GmshCursor {
 public:
  GmshCursor(const FormatFile& file, std::string_view section, bool binary, bool swapped)
      : file_(&file),
        at_(section.data()),
        end_(section.data() + section.size()),
        binary_(binary),
        swapped_(swapped) {}

  std::int64_t integer();  // binary: 32 bits
  std::uint64_t size();    // binary: 64 bits
  double real();
  // What is text in binary files, too.
  std::string_view word();  // up to the next blank
  std::string text();       // in quotes, up to the line's last: Gmsh writes others as they are;
                            // a line without any is the text itself
  std::string_view line();  // the rest of this one or, if that is blank, of the next that is not
  std::uint64_t count();    // a whole number
  void end_line();          // goes to the begin of the next line

  // How many there are, compared with what is left: each takes at least so many bytes.
  std::uint64_t rows(std::uint64_t claimed, std::uint64_t binary_bytes,
                     std::uint64_t numbers) const;
  void skip(std::uint64_t bytes);
  void skip_numbers(std::uint64_t count, std::uint64_t binary_bytes);
  void rest_is_blank() const;
  const char* at() const { return at_; }
  bool binary() const { return binary_; }
  [[noreturn]] void fail(const std::string& what) const { fail_at(at_, what); }
  [[noreturn]] void fail_at(const char* at, const std::string& what) const;
  [[noreturn]] void invalid_at(const char* at, const std::string& what) const;
  // So that at() is where the next number begins.
  void skip_blanks_of_text() {
    if (!binary_) skip_blanks();
  }

 private:
  void skip_blanks();
  template <class T>
  T binary_value();

  const FormatFile* file_;
  const char* at_;
  const char* end_;
  bool binary_;
  bool swapped_;
};

// What one $NodeData or $ElementData has of an array: all, or what a partition of the mesh has.
struct GmshDataSection {
  std::int64_t partition = 0;  // 0: none
  std::uint64_t rows = 0;
  std::string_view text;  // from the first row to the end of the section
};

struct GmshData {
  std::string name;
  std::optional<double> time;
  std::int64_t step = 0;
  std::uint64_t components = 1;
  std::vector<GmshDataSection> sections;  // of different partitions, if there are several
};

// What version 4.1 says of an entity, and so of all its elements.
struct GmshEntity {
  PhysicalGroups::Tags groups = {};
  std::int64_t physical = 0;     // of these the one that PhysicalGroups chooses; 0: none
  std::int64_t geometrical = 0;  // its tag; of a part of a partitioned entity that of the whole
  // Lies between parts of an entity of higher dimension: that is where a partition has cut it, and
  // says nothing of the mesh.
  bool is_seam = false;
};

// In what the versions differ, beside that version 4 has its nodes and elements in blocks, one or
// more for an entity.
struct GmshLayout {
  // 1: an element has two tags, and then says how many nodes it has, in place of how many tags.
  bool counts_nodes = false;
  // 4.0: the head of a block begins with the tag of its entity, else with its dimension.
  bool tag_first = false;
  // 4.1: the numbers of a block's nodes come before all their coordinates.
  bool numbers_first = false;
  std::uint64_t counts = 1;       // numbers that $Nodes and $Elements begin with
  std::uint64_t point_reals = 3;  // that say where a point of $Entities is; 4.0: the box around it
};

struct GmshHead {
  std::string version;
  GmshLayout layout;
  bool is_4 = false;
  bool binary = false;
  bool swapped = false;
  std::string_view nodes, elements;  // the sections, without the words that enclose them
  std::uint64_t node_count = 0;
  std::uint64_t element_count = 0;  // without those of seams
  std::uint64_t seam_elements = 0;
  std::vector<GmshName> names;
  std::map<std::pair<int, std::int64_t>, GmshEntity> entities;  // by dimension and tag
  std::vector<GmshData> node_data, element_data;
  std::vector<std::string> left_out;  // sections that are passed over, each once, and seams; groups

  // Reads what $Nodes and $Elements begin with.
  struct Counts {
    std::uint64_t blocks = 0;  // of version 4
    std::uint64_t rows = 0;
  };
  Counts read_counts(GmshCursor* in) const;
  // Reads what the head of a block begins with: dimension and tag.
  std::pair<int, std::int64_t> read_entity(GmshCursor* in) const;
  // Of one that is not listed no more is known than its tag.
  GmshEntity entity(int dimension, std::int64_t tag) const;
};

bool looks_like_gmsh(std::string_view text);

// Throws Error(kBadInput). No count is larger than the file can hold.
GmshHead parse_gmsh_head(const FormatFile& file);

struct GmshElementType {
  std::uint8_t vtk = 0;
  int nodes = 0;  // of each element; 0: this program does not know the type
};

GmshElementType gmsh_element_type(std::int64_t type);

}  // namespace tetfusion
