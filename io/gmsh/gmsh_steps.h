// Arrays that a Gmsh file has at several times: a view of several steps.
//
// Each step is an array of its own, "T at 0.5", so that its name says when. Written to a Gmsh file
// again, the arrays of one name are the steps of one view.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/gmsh/gmsh_head.h"
#include "mesh/data_array.h"

namespace tetfusion {

// What the arrays of a file's sections of one kind are called: by their name alone, unless another
// section has it at another time.
std::vector<std::string> gmsh_array_names(const std::vector<GmshData>& sections);

struct GmshTime {
  // That of all data that are no step and have one, but for 0: that is written where nobody knows
  // any.
  std::optional<double> time;
  std::string left_out;  // where they have different ones: "the different times of T, P"
};
GmshTime gmsh_time_of(const GmshHead& head);

// What the head of a section says.
struct GmshStep {
  std::string name;
  double time = 0;
  std::uint64_t number = 0;  // among the steps of that name
};
// Of each array of the set. One that is no step of several has the time that is given.
std::vector<GmshStep> gmsh_steps_of(const AttributeSet& set, double time);

}  // namespace tetfusion
