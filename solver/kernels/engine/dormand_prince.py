"""The coefficients of the explicit Runge-Kutta pair of Dormand and Prince of orders 5(4).

J. R. Dormand, P. J. Prince, A family of embedded Runge-Kutta formulae, J. Comp. Appl. Math. 6 (1980) 19-26, RK5(4)7S.
"""

ORDER = 5


C1, C2, C3, C4, C5 = 2 / 9, 1 / 3, 5 / 9, 2 / 3, 1.0


A1_0 = 2 / 9


A2_0, A2_1 = 1 / 12, 1 / 4


A3_0, A3_1, A3_2 = 55 / 324, -25 / 108, 50 / 81


A4_0, A4_1, A4_2, A4_3 = 83 / 330, -13 / 22, 61 / 66, 9 / 110


A5_0, A5_1, A5_2, A5_3, A5_4 = -19 / 28, 9 / 4, 1 / 7, -27 / 7, 22 / 7


B_0, B_2, B_3, B_4, B_5 = 19 / 200, 3 / 5, -243 / 400, 33 / 40, 7 / 80


# order 5 less the embedded order 4
ERROR_0, ERROR_2, ERROR_3, ERROR_4, ERROR_5, ERROR_LAST = (
    11 / 1250,
    -33 / 500,
    891 / 5000,
    -33 / 250,
    -9 / 1000,
    1 / 50,
)
