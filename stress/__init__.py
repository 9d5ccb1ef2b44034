"""The stability campaign: extreme columns, hostile input, faults and repeatability, seeded; not part of the product."""
