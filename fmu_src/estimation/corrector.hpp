// Every corrector behind one call, chosen at run time, with the innovation gate before it.
//
// They lie side by side rather than in a variant: settings can be changed between two epochs without loss of
// what a corrector has learned, and a saved state has one layout whatever was chosen. Settings are not part
// of it.
#pragma once

#include <algorithm>

#include "estimation/adaptive_factor.hpp"
#include "estimation/combined.hpp"
#include "estimation/gaussian.hpp"
#include "estimation/h_infinity.hpp"
#include "estimation/huber.hpp"
#include "estimation/igg.hpp"
#include "estimation/innovation_gate.hpp"
#include "estimation/standard.hpp"
#include "estimation/variational_bayes.hpp"

namespace truenorth {

template <int N, int M>
class Corrector {
  public:
    using Method = settings::Corrector;

    Method method = Method::standard;

    // Guards against lock-out, too: a prediction that has gone astray makes it refuse every good measurement,
    // for ever. After `gate.patience` of them in a row it is time to blame the prediction; 0: never.
    InnovationGate gate;

    bool gate_stands_open = false;  // for the next measurement, whatever its innovation
    bool way_back = false;          // under way: `combined` is the standard one behind the gate

    HInfinity<N> h_infinity;
    Igg<N> igg;
    AdaptiveFactor<N> adaptive_factor;
    VariationalBayes<M> variational_bayes;
    Huber huber;
    Combined<M> combined;  // judges by the gate's threshold itself; without the gate, it is the standard one

    // Takes the settings of all of them, from the groups of parameters; keeps what they have learned.
    template <class Parameters>
    void configure(const Parameters& p) {
        method = p.corrector;
        gate = p.gate;
        igg = p.igg;
        igg.guard = p.adaptive;
        adaptive_factor = p.adaptive;
        variational_bayes = p.variational_bayes;
        huber = p.huber;
        combined = p.combined;
    }

    // Third phase of the filter step. What the gate does not admit changes nothing and has no weight; nor has
    // an epoch without channels, which says nothing, of the prediction neither.
    Correction<N, M> correct(const Matrix<N>& prior, const Innovation<N, M>& innovation);

    // Its settings hold sigmas of the states, so that it matters which errors these are of.
    [[nodiscard]] bool knows_sigmas() const {
        return method == Method::h_infinity || method == Method::igg || method == Method::adaptive_factor ||
               method == Method::combined;
    }

    // What the last measurement was too large for; of the other correctors, nothing is told.
    [[nodiscard]] Cause cause() const { return judges() ? combined.cause() : Cause::none; }

    // Forgets what has been learned of a channel, which belongs to another source from now on.
    void restart(int channel) {
        variational_bayes.restart(channel);
        combined.restart(channel);
    }

    // The gate has refused as many measurements in a row as it may.
    [[nodiscard]] bool out_of_patience() const { return gate.patience > 0 && refused_ >= gate.patience; }

    // So many measurements in a row were larger than their covariance explains, refused or not: a noise that
    // is estimated counts as it was estimated, weights do not.
    [[nodiscard]] int contradictions() const { return contradictions_; }

    // Forgets what has been learned.
    void restart() {
        refused_ = 0;
        contradictions_ = 0;
        igg.restart();
        variational_bayes.restart();
        combined.restart();
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(refused_, contradictions_, igg, variational_bayes, combined);
    }

  private:
    static constexpr int kMostContradictions = 1000;

    [[nodiscard]] bool judges() const { return method == Method::combined && gate.enabled && !way_back; }

    Correction<N, M> corrected(const Matrix<N>& prior, const Innovation<N, M>& innovation);

    int refused_ = 0;         // in a row, counted up to gate.patience
    int contradictions_ = 0;  // in a row, counted up to kMostContradictions
};

// Not in the class, so that the correctors of a model can be compiled once, in a file of their own.
template <int N, int M>
Correction<N, M> Corrector<N, M>::correct(const Matrix<N>& prior, const Innovation<N, M>& innovation) {
    const int channels = innovation.channels();
    const auto none = [&] {
        return Correction<N, M>{Vector<N>::Zero(), prior, Vector<M>::Zero(), innovation.noise};
    };
    if (channels == 0) {
        return none();
    }
    const double nis = truenorth::nis(innovation);
    bool explained = gate.explains(nis, channels);
    const bool judged = judges();
    const bool admitted = judged || gate_stands_open || gate.admits(nis, channels);
    Correction<N, M> correction = admitted ? corrected(prior, innovation) : none();
    const bool taken = admitted && !(judged && !correction.used());
    refused_ = taken ? 0 : std::min(refused_ + 1, gate.patience);
    correction.nis = nis;
    const bool as_told =
        method == Method::standard || method == Method::h_infinity || (method == Method::combined && !judged);
    if (as_told || !taken) {
        correction.nis_used = nis;
        correction.channels_used = channels;
    } else {
        const Innovation<N, M> used = as_used(innovation, correction);
        correction.nis_used = truenorth::nis(used);
        correction.channels_used = used.channels();
    }
    if (taken && (judged || method == Method::variational_bayes)) {
        explained = gate.explains(correction.nis_used, correction.channels_used);
    }
    contradictions_ = explained ? 0 : std::min(contradictions_ + 1, kMostContradictions);
    return correction;
}

template <int N, int M>
Correction<N, M> Corrector<N, M>::corrected(const Matrix<N>& prior, const Innovation<N, M>& innovation) {
    switch (method) {
        case Method::h_infinity:
            return h_infinity.correct(prior, innovation);
        case Method::igg:
            return igg.correct(prior, innovation);
        case Method::adaptive_factor:
            return adaptive_factor.correct(prior, innovation);
        case Method::variational_bayes:
            return variational_bayes.correct(prior, innovation);
        case Method::huber:
            return huber.correct(prior, innovation);
        case Method::combined:
            if (judges()) {
                return combined.correct(prior, innovation, gate, gate_stands_open);
            }
            combined.restart();
            break;
        case Method::standard:
            break;
    }
    return Standard().correct(prior, innovation);
}

}  // namespace truenorth
