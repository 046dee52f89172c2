// Pieces that rooms are furnished with: walls, shelves of books, things on a table, trees.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "synth/rooms/furniture.h"
#include "synth/rooms/print.h"

namespace keypose::synth {

/// A stream of random numbers of its own for each piece, so that one more draw in a piece changes
/// no other.
class Streams {
 public:
  Streams(std::uint64_t seed, double detail) : detail_(detail), seed_(seed) {}
  PrintRandom Next() { return {Hash(seed_ * 1315423911ULL + ++count_), detail_}; }

 private:
  double detail_;
  std::uint64_t seed_, count_ = 0;
};

/// Four walls with pictures, a floor and a ceiling around [low, high], seen from within.
void AddWalls(Furniture& room, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
              Streams& streams);

/// A shelf of books and boxes. Its frame: x along the front, y into the shelf, z up from its foot.
void AddShelf(Furniture& room, const Rigid3& room_from_shelf, const Eigen::Vector3d& size,
              Streams& streams);

/// A table's top at z with a cloth or boards, around (x, y); the cloth hangs down at its sides.
void AddTable(Furniture& room, const Eigen::Vector3d& middle, double wide, double deep,
              Streams& streams);

/// A book that lies with its middle above (x, y), its lower side at z.
/// @param size  along, across, thickness [m]
void AddLyingBook(Furniture& room, const Eigen::Vector3d& at, const Eigen::Vector3d& size,
                  double turn_rad, Part part, Streams& streams);

/// A small thing to put beside a figure, with its foot at the origin of its frame.
enum class ThingKind { kBlock, kMug, kTin, kBox };
/// @return its radius [m] around its axis
double AddThing(Furniture& room, ThingKind kind, const Rigid3& room_from_thing, Part part,
                PrintRandom random);

/// A tree from z = low to high, with bark.
void AddTree(Furniture& room, const Eigen::Vector2d& at, double radius, double low, double high,
             PrintRandom random);

}  // namespace keypose::synth
