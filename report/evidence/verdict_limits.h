// All limits of the verdicts: where *good* ends and where *wrong* begins. docs/stages/report.md has
// a table with measurements of good and of spoilt sets.
#pragma once

namespace keypose::report {

// Outlines: mean distance between the outlines of the mesh and the first mask, divided by the
// figure's size in the picture; median over the views.
constexpr double kOutlineGood = 0.0025, kOutlineWrong = 0.010;
// For a single view: above this limit the view is named.
constexpr double kViewOutlineLook = 0.008;
// A part of the figure that a mask shows and the mesh lacks: its share of the figure in the
// picture. Above this limit in two photographs it is told.
constexpr double kMissingLook = 0.01;
// Details: correlation of render and photograph; median over the views.
constexpr double kStructureGood = 0.6, kStructureWrong = 0.2;
constexpr double kViewStructureLook = 0.3;
// Share of the outline across which the photograph changes its colour.
constexpr double kEdgesGood = 0.5;

// Limits on the stages' own measurements.
constexpr double kSharpnessLook = 0.40;    // capture: photographs in focus have 0.52 to 0.75
constexpr double kPlacedGood = 0.9;        // sfm: share of the photographs
constexpr double kReprojectionGood = 1.0;  // sfm [px]
constexpr double kEvidenceLook =
    0.08;  // refine: share of the surface that the photographs determine
constexpr double kClosedFarLook = 0.02;  // cleanup: of the diagonal
// cleanup: share of the surface that no camera sees, soles left out; of a figure shot from one ring
// at 25 degrees 0.06, of one shot from all sides less
constexpr double kUnseenSurfaceLook = 0.1;
constexpr double kUnseenLook = 0.25;   // bake: share of the texels
constexpr double kFlipsLook = 0.0003;  // register: of the triangles; flat soles have 3 of 20,000
// register: of the triangles; a hand pressed on a hip has 0.002
constexpr double kFlipsWrong = 0.005;
constexpr double kRegisteredGood = 0.004,
                 kRegisteredWrong = 0.015;  // register: rms over the diagonal
constexpr double kLandmarkLook = 0.03;      // register: of the diagonal
constexpr double kStretchLook = 2.5;        // register: 1 % and 99 % of the edges

// Of a pose from few photographs, which the template is bent into.
constexpr double kFittedIouGood = 0.95, kFittedIouWrong = 0.85;  // mean over its photographs
constexpr double kFittedUnseenLook = 0.4;  // fit: share of the vertices that no photograph shows
constexpr double kFittedVolumeLook = 0.1;  // fit: change of the template's volume
// fit: EXIF's focal length against that of the template's photographs. A lens that is focused
// elsewhere changes it by less.
constexpr double kFittedFocalLook = 0.05;

// Of a shot of a performance: track's overlap of body and masks, mean over frames and cameras.
constexpr double kTrackedIouGood = 0.9, kTrackedIouWrong = 0.75;
constexpr double kTransferVolumeLook = 0.02;  // transfer: largest change of a part's volume

}  // namespace keypose::report
