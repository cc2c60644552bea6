#include "plant/outliers.hpp"

namespace truenorth::plant {

Eigen::Vector3d Outliers::draw(const NoiseStream& stream, std::uint64_t fix) const {
    const Eigen::Vector4d u = stream.uniform(fix);
    if (u[3] >= probability) {
        return Eigen::Vector3d::Zero();
    }
    return size * (u.head<3>().array() - 0.5).sign();
}

Eigen::Matrix<double, 6, 1> OutlierEpochs::draw(const NoiseStream& stream, std::uint64_t fix) const {
    constexpr std::uint64_t draws = 7;  // of a fix: one for the epoch, one for each component
    Eigen::Matrix<double, 6, 1> error = Eigen::Matrix<double, 6, 1>::Zero();
    if (stream.uniform(draws * fix)[0] >= probability) {
        return error;
    }
    for (Eigen::Index i = 0; i < error.size(); ++i) {
        const Eigen::Vector4d u = stream.uniform(draws * fix + 1 + static_cast<std::uint64_t>(i));
        if (u[0] < channel_probability) {
            error[i] = (u[1] < 0.5 ? -1.0 : 1.0) * (least + u[2] * (largest - least));
        }
    }
    return error;
}

}  // namespace truenorth::plant
