// Constructors of Eigen vectors. Eigen includes this file inside its classes PlainObjectBase and
// Matrix (see types.hpp). Included anywhere else, it is empty.
#ifdef SALTUS_INSIDE_PLAIN_OBJECT
#ifdef EIGEN_MATRIX_H  // in Matrix
/// One scalar for a vector with one row, so that a formula may `return {u[0]};`.
Matrix(const Scalar& x)  // NOLINT(google-explicit-constructor)
  requires(int(Base::SizeAtCompileTime) == 1)
    : Base() {
  this->coeffRef(0) = x;
}
#else  // in PlainObjectBase
// Constructors for a wrong number of active scalars, so that the compiler reports one sentence
// instead of a list of all constructors.
/// One scalar for a vector with a different number of rows.
template <class T>
  requires(std::is_same_v<T, Scalar> && std::is_class_v<T> && int(Base::SizeAtCompileTime) != 1)
void _init1(const T&) {
  static_assert(Base::SizeAtCompileTime == 1, SALTUS_WRONG_NUMBER_OF_ENTRIES);
}
/// Two scalars for a vector with a different number of rows.
template <class T0, class T1>
  requires(std::is_class_v<Scalar> && (std::is_same_v<T0, Scalar> || std::is_same_v<T1, Scalar>) &&
           int(Base::SizeAtCompileTime) != 2)
void _init2(const T0&, const T1&) {
  static_assert(Base::SizeAtCompileTime == 2, SALTUS_WRONG_NUMBER_OF_ENTRIES);
}
#endif
#endif
