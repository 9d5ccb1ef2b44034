"""Another model: one slender rigid block on a rigid floor that it hits without a rebound (G. W. Housner, 1963).

theta (rad, clockwise) rocks by theta'' = p^2 (theta - s alpha - a / g): s its sign, a the acceleration of the base, p^2
= 3 g / (4 R), R half the diagonal, alpha the slenderness angle. An impact multiplies the rate by the restitution.
Between impacts this is in closed form.

    simulate(Block(1.0, 4.0), motion); ida(Block(1.0, 4.0), motions, levels)
    import rigid_block.subject; check(Block(1.0, 4.0), motions)
    import rigid_block.fmu; build_fmu(Block(1.0, 4.0), Path("block.fmu"))
"""
