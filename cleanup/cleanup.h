// Any triangle mesh to a closed, oriented 2-manifold without self-intersections, at a wanted size.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cleanup/see_through.h"
#include "core/mesh.h"
#include "core/options.h"
#include "core/progress.h"

namespace keypose::cleanup {

struct CleanupOptions {
  int faces = 20000;                ///< wanted number of faces; surfaces with more are remeshed to it
  bool refine = false;              ///< also remesh surfaces that have fewer faces than wanted
  std::string remesh = "adaptive";  ///< adaptive: smaller triangles where the surface bends; uniform: equal ones
  int genus = -2;  ///< handles of the result; surplus ones are cut or filled; -1 keeps all; -2: as many as the photographs see through
  std::string stand = "auto";   ///< auto: a level sheet that the figure stands on (z up) is cut off; keep: nothing is
  std::string ground = "auto";  ///< auto: StandsOnGround is asked whether soles are cut flat at z = 0; keep: nothing is
  int keep_components = 1;      ///< pieces of the result, largest first; 0 keeps all
  double min_component = 0.02;  ///< pieces with less than this share of the largest one's area are dropped at once
  bool wrap = true;             ///< allow the last rung, an alpha wrap
  double wrap_alpha = 0;        ///< its alpha over the diagonal; 0 chooses it from `faces`
  void Describe(OptionVisitor& visit);
};

/// How far two surfaces are apart, over the diagonal; sampled uniformly by area.
struct SurfaceDistance {
  double mean = 0, p99 = 0, max = 0;
};

struct CleanupResult {
  Mesh mesh;         ///< closed; colours when the input had them
  std::string rung;  ///< as-is, R0 weld, R2 fill, R3 intersections, R4 wrap
  int holes_filled = 0;
  double largest_hole_over_diag = 0;
  int components_removed = 0;
  int stands_removed = 0;                 ///< turntables, plates and cloths cut off below the figure
  double cut_below_ground_over_diag = 0;  ///< depth of what was cut off at the ground
  int merged_vertices = 0;
  int self_intersections_before = 0;  ///< intersecting pairs of faces once the surface was welded and its holes filled
  int self_intersections = 0;         ///< of the result: always 0
  int components = 0;
  int genus_before = 0;  ///< handles of the closed surface before any was cut
  int handles_cut = 0;
  double largest_handle_cut_over_diag = 0;  ///< length of the longest loop that one was cut along
  int handles_seen_through = 0;             ///< of the result, by the lines of sight
  int genus = 0;                            ///< of all components together
  double area = 0, volume = 0;              ///< [input units ^2, ^3]
  double min_angle_deg = 0;
  double mean_min_angle_deg = 0;
  SurfaceDistance to_input;    ///< from the result to the input
  SurfaceDistance from_input;  ///< from the kept part of the input to the result
  double undamaged_share = 1;  ///< of the kept input's area, that lies farther than an edge of the result from whatever was repaired
  SurfaceDistance undamaged_to_input, undamaged_from_input;  ///< the same distances on that part: what the new size costs
};

/// Repairs by the least destructive means that pass the test: closed, oriented, one fan a vertex, positive volume, no face without
/// area, no two faces that intersect (exact predicates).
///
/// @param surface  any triangles with finite vertices; colours optional
/// @param lines    what photographs see through the figure (LinesThroughHoles), in the surface's frame; without them no handle is kept
///                 unless options.genus says so
/// @param ground   height along z on which the figure stands (StandsOnGround): what lies below goes, and the soles are flat there
/// @throws InputError    empty or not finite, says where; or nothing with a volume can be made of it; or fewer handles than options.genus
/// @throws QualityError  every rung failed; says what the last one lacked
/// A mesh that passes already, with `keep_components` pieces, the wanted genus and not more than `faces` faces, is returned bit for bit.
/// Cost: about 5 s for 300,000 faces to 20,000, 18 s for 2 million. Same bits for any thread count.
/// Source: the ladder is ours; each rung's source stands in its header.
CleanupResult MakeClosedManifold(const Mesh& surface, const CleanupOptions& options, Progress* progress = nullptr,
                                 const std::vector<SightLine>& lines = {}, const std::optional<double>& ground = {});

/// Handles that the options let a closed surface keep. @param lines  in its frame
int WantedGenus(const Mesh& closed, const CleanupOptions& options, const std::vector<SightLine>& lines);

}  // namespace keypose::cleanup
