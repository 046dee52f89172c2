// Which photographs of a set show another thing than the others, before anything is learned from
// them.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "core/values/image.h"
#include "core/values/progress.h"

namespace keypose::capture {

/// Share of pixels by colour, for the colours that occur; in ascending order of the colour.
using ColourShares = std::vector<std::pair<int, float>>;

/// What a picture's colours tell of the thing in its middle.
struct ColourSketch {
  ColourShares middle, border;
  ColourShares own;      ///< of the middle, by as much as it has more of a colour than the border
  double own_share = 0;  ///< their sum, in [0, 1]; near 0: the middle looks as the border does
};

/// Colours in CIE Lab, 10 x 16 x 16 of them, each pixel shared out among its eight nearest, of the
/// picture at 96 pixels.
/// @param picture  RGB
/// @param print    255 where a known print shows, such as a board that all figures stand on, which
/// does not count; empty: nowhere
ColourSketch SketchOf(const Image8& picture, const Image8& print = {});

/// How unlike two pictures are by colour: the larger of two distances of distributions (1 minus
/// what they share), each over what different things have at least: of the middles (0.56), and of
/// what the middles have of their own (0.75). Neighbours on a ring
/// have 0.1 to 0.5, the least like of one set 0.3 to 1, two things mostly 1.1 and more.
double Unlikeness(const ColourSketch& first, const ColourSketch& second);

/// The photographs by the things that they show, the largest group first, each ascending. Two
/// photographs show one thing where they are alike by colour, directly or through others, as views
/// of a ring are through their neighbours; or where features that move from one to the other fit
/// one rigid scene, so that neither another lamp nor another side makes a second thing of it.
/// Sets whose neighbours are far apart are judged by their own chain.
/// @param pictures  RGB, some 500 px
/// @param prints    as in SketchOf, one per picture; features on them tie nothing together
/// Same result for any thread count.
/// Cost: some ms per photograph, and 1 ms for each pair of which one is not like most.
std::vector<std::vector<std::size_t>> ThingsShown(const std::vector<Image8>& pictures,
                                                  const std::vector<ColourSketch>& sketches,
                                                  const std::vector<Image8>& prints = {},
                                                  Progress* progress = nullptr);

/// Pairs of one view, such as a photograph that was saved a second time: they differ by less than
/// a third of what neighbours do, and by at most 1.5 levels in the mean. In ascending order.
std::vector<std::pair<std::size_t, std::size_t>> SameViews(
    const std::vector<Image8>& pictures, const std::vector<ColourSketch>& sketches);

}  // namespace keypose::capture
