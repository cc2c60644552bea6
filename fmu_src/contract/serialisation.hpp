// How cereal stores Eigen's fixed-size types: their coefficients, in storage order.
#pragma once

#include <Eigen/Geometry>
#include <cereal/cereal.hpp>

namespace cereal {

template <class Archive, class Scalar, int Rows, int Cols, int Options>
void serialize(Archive& archive, Eigen::Matrix<Scalar, Rows, Cols, Options>& matrix) {
    static_assert(Rows != Eigen::Dynamic && Cols != Eigen::Dynamic, "states have a fixed size");
    archive(binary_data(matrix.data(), sizeof(Scalar) * static_cast<std::size_t>(matrix.size())));
}

template <class Archive, class Scalar, int Rows, int Cols, int Options>
void serialize(Archive& archive, Eigen::Array<Scalar, Rows, Cols, Options>& array) {
    static_assert(Rows != Eigen::Dynamic && Cols != Eigen::Dynamic, "states have a fixed size");
    archive(binary_data(array.data(), sizeof(Scalar) * static_cast<std::size_t>(array.size())));
}

template <class Archive, class Scalar, int Options>
void serialize(Archive& archive, Eigen::Quaternion<Scalar, Options>& q) {
    archive(binary_data(q.coeffs().data(), sizeof(Scalar) * 4));
}

}  // namespace cereal
