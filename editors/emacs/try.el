;;; try.el --- looks at what the server tells of main.rhai  -*- lexical-binding: t -*-
;;; Code:

(setq eglot-sync-connect 20)

(defun try-wait (what condition)
  "Wait until CONDITION holds; end Emacs naming WHAT if it never does."
  (let ((end (+ (float-time) 20)))
    (while (and (not (funcall condition)) (< (float-time) end))
      (accept-process-output nil 0.05))
    (unless (funcall condition)
      (princ (format "nothing arrived: %s\n" what))
      (kill-emacs 1))))

(find-file "main.rhai")
(apply #'eglot (eglot--guess-contact))
(try-wait "the server" #'eglot-current-server)

(defun try-messages ()
  "Return the texts of all messages about the buffer."
  (flymake-start)
  (accept-process-output nil 0.1)
  (mapconcat #'flymake-diagnostic-text (flymake-diagnostics) "\n"))

(flymake-mode 1)
(try-wait "the message of a text that does not parse" (lambda () (not (string= "" (try-messages)))))
(goto-char (point-max))
(skip-chars-backward "\n")
(let ((found (eglot-completion-at-point)))
  (unless (member "boundary_where" (all-completions "" (nth 2 found)))
    (princ "no completion of `plate.'\n")
    (kill-emacs 1)))
(delete-region (line-beginning-position) (point))
(insert "print(plate);")
;; Idle timers, which tell the server of changes, do not run without a screen.
(eglot--signal-textDocument/didChange)
(try-wait "the message of a boundary that does not exist"
          (lambda () (string-match-p "did you mean \"bottom\"" (try-messages))))
(goto-char (point-min))
(search-forward "plate")
(eglot-rename "sheet")
(unless (string-match-p "print(sheet)" (buffer-string))
  (princ "no renaming of `plate'\n")
  (kill-emacs 1))
(set-buffer-modified-p nil)
(kill-emacs 0)
;;; try.el ends here
