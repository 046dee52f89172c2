// The description file of an armature, in the form of the paper's Figure 2.
//
//     units mm                      # of lengths; none: pure numbers
//     node {
//       name  rightKneeBend
//       axis  1 0 0                 # a hinge, in its parent's frame
//       sensor 5
//       scale 25                    # encoder revolutions for one of the joint; its sign the sense
//       node { name rightCalve  length 40
//         node { name rightAnkleSwivel  axis 0 0 1  sensor 6  scale -10 }
//       }
//     }
//
// The whole of it is in docs/file-formats.md. Source: Knep et al., CHI 1995, Figure 2. The paper's
// text calls `scale` joint revolutions to encoder revolutions, its example is the inverse, which is
// the default here; `scale_is joint_per_encoder` takes the text by its word.
#pragma once

#include <string>
#include <vector>

#include "armature/description/armature.h"
#include "armature/description/words.h"

namespace keypose::armature {

enum class ScaleSense { kEncoderPerJoint, kJointPerEncoder };

/// A description and the file that it was read from: to change a number in it leaves all other
/// bytes, comments too, as they were.
class DescriptionFile {
 public:
  /// @param file  its name, for messages
  /// @throws InputError  with line and column: malformed, an unknown word (names the nearest known
  /// one), a name or a sensor that is given twice, a joint without sensor, nodes nested more than
  /// 200 deep, more than 10,000 of them
  static DescriptionFile Parse(const std::string& text, const std::string& file);

  const Armature& armature() const { return armature_; }
  ScaleSense scale_is() const { return scale_is_; }
  /// The file as it is now.
  std::string Text() const { return JoinWords(words_); }
  /// Writes a joint's gear ratio, in the file's sense. One that the file does not have is added
  /// behind the sensor's index.
  /// @param scale  encoder revolutions per revolution of the joint (or unit of a slide), not 0
  void SetScale(int node, double scale);

 private:
  friend class DescriptionParser;
  std::vector<Word> words_;
  Armature armature_;
  ScaleSense scale_is_ = ScaleSense::kEncoderPerJoint;
  /// For each node the places of the words that hold its sensor and its scale; 0: none.
  struct Places {
    std::size_t sensor = 0, scale = 0;
  };
  std::vector<Places> places_;
};

/// A file for an armature that was made, not read: one attribute a line, children indented, lengths
/// in millimetres if the armature has a unit.
/// @pre nodes stand in file order
std::string DescriptionText(const Armature& armature);

}  // namespace keypose::armature
