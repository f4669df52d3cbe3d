/// Complex numbers: plane vectors that are turned and scaled by a factor, as in navigation, where they are east + i
/// north.
#pragma once

#include "hypertuna/math/scalar.hpp"

namespace hypertuna::inline HYPERTUNA_ARCH {

template <class T>
struct Complex {
    T re, im;
};

template <class T>
Complex<T> operator+(Complex<T> a, Complex<T> b) {
    return {a.re + b.re, a.im + b.im};
}
template <class T>
Complex<T> operator-(Complex<T> a, Complex<T> b) {
    return {a.re - b.re, a.im - b.im};
}
template <class T>
Complex<T> operator*(T a, Complex<T> b) {
    return {a * b.re, a * b.im};
}
template <class T>
Complex<T> operator*(Complex<T> a, Complex<T> b) {
    return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
template <class T>
Complex<T> conj(Complex<T> a) {
    return {a.re, -a.im};
}
/// Squared magnitude.
template <class T>
T square(Complex<T> a) {
    return a.re * a.re + a.im * a.im;
}

}  // namespace hypertuna::inline HYPERTUNA_ARCH
