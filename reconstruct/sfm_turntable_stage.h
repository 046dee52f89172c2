// The strategies of sfm that believe in a turntable: a ring model from matches, the same in an order found, and outlines alone.
#pragma once

#include "reconstruct/sfm_ladder_stage.h"

namespace keypose::reconstruct {

/// Asks these strategies where `best`, which was found before, is in doubt or leaves photographs out, and puts what the evidence prefers in
/// its place. Photographs that are upside down are turned over for them, and their cameras turned back. Where no photograph tells the focal
/// length, several are tried.
void PlaceByTurntable(const Ladder& ladder, const SfmFiles& files, const Seen& seen, Placed& best);

/// Focal lengths worth trying, in pixels, the likeliest first: that which the photographs tell, else those of lenses from 26 to 92 mm (as
/// of 35 mm film) in steps of a fifth.
std::vector<double> FocalsToTry(const Seen& seen);

/// The camera with another focal length.
Camera WithFocal(Camera camera, double focal_px);

}  // namespace keypose::reconstruct
