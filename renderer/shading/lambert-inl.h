// Written once for single numbers and for lanes (numbers.h): included by lambert.h, and by
// lambert_lanes-inl.h for each instruction set.

/// Scales the colour so that its largest component is at most 1, lest more light come back than
/// came.
TESSERA_INLINE NumColor bounded(const NumColor& color) {
  const Num largest = max_component(color);
  return select(largest > num(1), color * (num(1) / largest), color);
}

/// What a surface sends on, by cosine: BSDF * |cosine|, and the density with which sample() chooses
/// that direction, per steradian. Mirrors and smooth glass have no part in it.
struct BsdfValue {
  NumColor f_cosine = num_color(0);  ///< BSDF * |cosine|
  Num density = num(0);
};

/// Per steradian, of directions that are spread over the hemisphere by their cosine.
TESSERA_INLINE Num cosine_density(Num cosine) {
  return maximum(cosine, num(0)) * num(1 / portable::kPi);
}

/// A surface that scatters evenly. What would go to its other side is mirrored at it.
class Lambert {
 public:
  /// `normal` is that for shading, `facet` the geometric one, towards the viewer; both unit.
  TESSERA_INLINE Lambert(const NumColor& diffuse, const Num3& normal, const Num3& facet)
      : albedo_(bounded(diffuse)), normal_(normal), facet_(facet) {}
  const NumColor& albedo() const { return albedo_; }
  TESSERA_INLINE BsdfValue evaluate(const Num3& wi) const {
    const NumMask is_before = dot(wi, facet_) > num(0);
    const Num density = select(is_before, cosine_density(dot(wi, normal_)), num(0));
    const Num mirrored = select(is_before, density_mirrored_to(wi), num(0));
    return {albedo_ * density + albedo_ * mirrored, density + mirrored};
  }
  /// Whether there is a direction to go on in.
  TESSERA_INLINE NumMask sample(const Num2& u, Num3& wi, Num& density) const {
    const Num3 local = cosine_hemisphere_point(u);
    wi = Frame(normal_).from_local(local);
    density = cosine_density(local.z) + density_mirrored_to(wi);
    const Num height = dot(wi, facet_);
    wi = select(height < num(0), reflect(wi, facet_), wi);
    return both(local.z > num(0), height != num(0));
  }

 private:
  /// Of what is mirrored at the surface into `wi`.
  TESSERA_INLINE Num density_mirrored_to(const Num3& wi) const {
    return cosine_density(dot(reflect(wi, facet_), normal_));
  }

  NumColor albedo_;
  Num3 normal_, facet_;
};
