;;; conserva.el --- scripts of Conserva  -*- lexical-binding: t -*-

;; Emacs 29 or newer, or Emacs 26.3 with the package eglot: (load "/path/to/conserva.el") in init.el.

;;; Code:

(require 'eglot)
(require 'js)

;;;###autoload
(define-derived-mode conserva-mode js-mode "Conserva"
  "Mode for scripts of Conserva; the highlighting is that of JavaScript."
  (setq-local comment-start "// "
              indent-tabs-mode nil
              js-indent-level 4))

;;;###autoload
(add-to-list 'auto-mode-alist '("\\.rhai\\'" . conserva-mode))

(add-to-list 'eglot-server-programs '(conserva-mode . ("conserva" "lsp")))
(add-hook 'conserva-mode-hook #'eglot-ensure)

(provide 'conserva)
;;; conserva.el ends here
