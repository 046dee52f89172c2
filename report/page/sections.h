// The sections of the page, one function each. They return HTML; empty if there is nothing to show.
#pragma once

#include <string>

#include "report/evidence/contents.h"

namespace keypose::report {

std::string StepsSection(const Contents& contents);
std::string PoseSection(const Contents& contents, const PosePart& pose, const Encoder& encode);
std::string PairSection(const PairPart& pair, const Encoder& encode);
/// What the steps that are of no pose say of themselves, but for those with a section of their own.
std::string OtherStepsSection(const Contents& contents);
std::string AnimationSection(const Contents& contents, const Encoder& encode);

/// Poster and controls of the player; empty if there is no player.
std::string PlayerSection(const Contents& contents, const Encoder& encode);
/// The player's data and script, for the end of the page.
std::string PlayerProgram(const Contents& contents);

/// All measurements of a step, collapsed.
std::string EverythingMeasured(const StepRecord& step);
std::string Shots(const std::vector<Picture>& pictures, const Encoder& encode);
/// Large pictures, two or three per row.
std::string WidePictures(const std::vector<Picture>& pictures, const Encoder& encode);
/// "reprojection_error_px" -> "reprojection error (px)".
std::string Words(const std::string& name);

}  // namespace keypose::report
