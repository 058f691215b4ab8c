"""Success under variation: random tasks, carried out in processes of their own, judged, counted and explained."""
