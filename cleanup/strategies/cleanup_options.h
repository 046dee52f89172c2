// Options of the cleanup.
#pragma once

#include <string>

#include "core/values/options.h"

namespace keypose::cleanup {

struct CleanupOptions {
  int faces = 20000;    ///< wanted number of faces; surfaces with more are remeshed to it
  bool refine = false;  ///< also remesh surfaces that have fewer faces than wanted
  /// adaptive: smaller triangles where the surface bends; uniform: equal ones
  std::string remesh = "adaptive";
  int genus = -2;  ///< handles of the result; others are cut or filled; -1 keeps all; -2 keeps as
                   ///< many as the photographs see through
  std::string support = "auto";  ///< auto: cuts off a level sheet that the figure stands on (z up);
                                 ///< keep: cuts nothing
  std::string ground =
      "auto";               ///< auto: soles are cut flat at z = 0 if StandsOnGround; keep: no cut
  int keep_components = 1;  ///< pieces of the result, largest first; 0 keeps all
  /// pieces with less than this share of the largest one's area are removed first
  double min_component = 0.02;
  bool wrap = true;       ///< allow the last strategy, an alpha wrap
  double wrap_alpha = 0;  ///< its alpha over the diagonal; 0 chooses it from `faces`
  /// texture coordinates of the surface may go without a warning, as another stage carries the
  /// colours over
  bool drop_layout = false;
  void Describe(OptionVisitor& visit);
};

}  // namespace keypose::cleanup
