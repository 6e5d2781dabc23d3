"""Terms that users write as forms of scikit-fem on the deformed surface."""

from skancf.terms.forms.form_term import FormTerm

__all__ = ["FormTerm"]
