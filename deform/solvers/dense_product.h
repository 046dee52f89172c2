// Products of dense matrices with BLAS.
#pragma once

#include <Eigen/Core>

namespace keypose {

enum class Flip { kNone, kFirst, kSecond };

/// product = factor * a b + keep * product, where `flip` names the matrix to transpose. `product`
/// must have its final size; with keep = 0 its old values are ignored.
/// BLAS uses the processor's widest vector instructions and takes a fifth of the time of Eigen's
/// product, which is compiled for the baseline processor.
/// Same bits for any thread count.
void Multiply(float factor, const Eigen::Ref<const Eigen::MatrixXf>& a,
              const Eigen::Ref<const Eigen::MatrixXf>& b, Flip flip, float keep,
              Eigen::Ref<Eigen::MatrixXf> product);
void Multiply(double factor, const Eigen::Ref<const Eigen::MatrixXd>& a,
              const Eigen::Ref<const Eigen::MatrixXd>& b, Flip flip, double keep,
              Eigen::Ref<Eigen::MatrixXd> product);

}  // namespace keypose
