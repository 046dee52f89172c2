// What a person said the figure of a pose, or of a performance's shot, is: the option `figure` of
// the step that makes its masks, in the project's pipeline.yaml.
#pragma once

#include <string>
#include <vector>

#include "core/values/figure_strokes.h"
#include "pipeline/graph/graph.h"
#include "pipeline/graph/pipeline_file.h"

namespace keypose::pipeline {

inline constexpr const char* kFigureOption = "figure";

/// The step that is told what the figure is: `masks` of a pose of many photographs, `capture` of
/// one of few, `silhouettes` of a shot.
/// @param pose  or shot
/// @throws UsageError  there is no such pose or shot, or none of its steps makes masks: says why
const Step& FigureStep(const Graph& graph, const std::string& pose);

/// What is said so far. @throws UsageError  the option's text is not of the form
std::vector<FigureStroke> FigureStrokesOf(const Step& step);

/// The text of pipeline.yaml with other strokes for the step's pose; without strokes, the setting
/// goes.
/// @param file  what `text` says
/// @throws UsageError  it cannot be edited so
std::string WithFigure(const PipelineFile& file, const std::string& text, const Step& step,
                       const std::vector<FigureStroke>& strokes);

/// The photograph that a person means, of those in a pose's folder.
/// @param files  paths below the folder, of photographs alone
/// @param typed  such a path, or the name of one alone, or its name as `capture` writes it
/// @throws UsageError  none, or several; names the nearest
std::string PhotographMeant(const std::vector<std::string>& files, const std::string& typed);

/// @param size  of the stroke's picture, upright
/// @throws UsageError  a point lies outside of it
void RequireWithin(const FigureStroke& stroke, PictureSize size);

/// @throws UsageError  a place that is said both to be the figure and not to be it
void RequireNoContradiction(const std::vector<FigureStroke>& strokes);

/// Adds strokes that are not there yet.
std::vector<FigureStroke> WithStrokes(std::vector<FigureStroke> strokes,
                                      const std::vector<FigureStroke>& more);

/// The steps that come after a step, directly or through others.
std::vector<const Step*> StepsThatFollow(const Graph& graph, const Step& step);

}  // namespace keypose::pipeline
