// What locate tells of its result: shot.json, measurements, and a picture of what the mesh and the
// filmed sculpt differ by.
#pragma once

#include "composite/locate_input.h"
#include "core/values/filmed_shot.h"

namespace keypose::composite {

/// Of a moving camera: a picture that shows no key pose.
bool IsBetween(const LocateInput& input, int frame);
FilmedShot ShotOf(const LocateInput& input, const LocatedShot& located);

void ReportShot(StageContext& stage, const LocateInput& input, const LocatedShot& located);

/// The frames, up to six, with the mesh's outlines: green where they lie on the matte's, to orange
/// where the filmed figure is larger and blue where it is smaller, full at 3 px.
Image8 DriftPicture(const LocateInput& input, const LocatedShot& located);

}  // namespace keypose::composite
