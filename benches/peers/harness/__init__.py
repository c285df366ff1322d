"""The comparison of isopatch with other programs; `benches/peers/run` starts it."""
