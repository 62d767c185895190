"""Results for people: pictures, tables, words, pages. Imported at first use: matplotlib takes its time."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "comparison_pictures": ["plot_comparison", "plot_run"],
        "diagnosis": ["diagnosis_text"],
        "frames": ["figures_frame", "series_dataset"],
        "log_pictures": ["plot_identification", "plot_replay", "plot_score"],
        "page": ["comparison_html"],
        "study_pictures": ["plot_bandwidths"],
    },
)
