// Written once for single numbers and for lanes (numbers.h): included by light.h, and by
// light_lanes-inl.h for each instruction set.

/// What a light sends to a point.
struct LightSample {
  Num3 wi;       ///< unit, from the point to the light
  Num distance;  ///< metres; infinite for a directional light
  Num factor;    ///< attenuation * beam shape
};

/// Sets where the place of a light lies that is `to_light` away; false if it is none.
TESSERA_INLINE NumMask sample_place(const Num3& to_light, LightSample& sample) {
  sample.distance = square_root(dot(to_light, to_light));
  sample.wi = to_light / sample.distance;
  return sample.distance > num(0);
}

/// Sets the factor by the distance; false where nothing is left.
TESSERA_INLINE NumMask attenuate(const Light& light, Num path_length, LightSample& sample) {
  const LightAttenuation& a = light.attenuation;
  const Num scale = num(light.frame_scale), reach = sample.distance * scale;
  const Num d = a.whole_path ? (sample.distance + path_length) * scale : reach;
  Num denominator = num(a.constant) + d * (num(a.linear) + d * num(a.quadratic));
  if (a.is_none()) denominator = select(denominator > num(0), denominator, num(1));
  if (a.at_most_one) denominator = maximum(denominator, num(1));
  sample.factor = select(denominator > num(0), num(a.scale) / denominator, num(0));
  return and_not(sample.factor > num(0), reach > num(light.radius));
}
